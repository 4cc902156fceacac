"""Comparison of a page's shown output with a command's output."""

from __future__ import annotations

import re

import pytest

NUMBER = r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?"
LEFT_OUT = "…"


def words(line):
    return re.sub(NUMBER, "", line).split()


def numbers(line):
    return [float(found) for found in re.findall(NUMBER, line)]


def is_shown(line, printed):
    """Whether words are equal, and numbers to 5 %.

    The last digits of p-values depend on the fit, which differs on another processor.
    """
    return words(line) == words(printed) and numbers(line) == pytest.approx(numbers(printed), rel=0.05)


def require_shown(text, printed):
    """Each line of a block stands in what was printed, in its order."""
    left = printed.splitlines()
    for line in filter(None, (line.strip() for line in text.splitlines() if line.strip() != LEFT_OUT)):
        found = [index for index, each in enumerate(left) if is_shown(line, each)]
        assert found, f"not printed any more: {line}\n" + "\n".join(each for each in left if words(each) == words(line))
        left = left[found[0] + 1 :]
