"""The tutorial's commands print what it shows, in an empty directory."""

import re
import shlex
from pathlib import Path

import pytest

TUTORIAL = (Path(__file__).parents[2] / "docs" / "tutorial.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w*)\n(.*?)```", TUTORIAL, re.DOTALL)
NUMBER = r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?"
LEFT_OUT = "…"


def words(line):
    return re.sub(NUMBER, "", line).split()


def numbers(line):
    return [float(found) for found in re.findall(NUMBER, line)]


def is_shown(line, printed):
    """The same words, and numbers to 5 %: the last digits of p-values are of those of a fit on another processor."""
    return words(line) == words(printed) and numbers(line) == pytest.approx(numbers(printed), rel=0.05)


def require_shown(text, printed):
    """Each line of a block stands in what was printed, in its order."""
    left = printed.splitlines()
    for line in filter(None, (line.strip() for line in text.splitlines() if line.strip() != LEFT_OUT)):
        found = [index for index, each in enumerate(left) if is_shown(line, each)]
        assert found, f"not printed any more: {line}\n" + "\n".join(each for each in left if words(each) == words(line))
        left = left[found[0] + 1 :]


def test_it_shows_what_its_commands_print(enter, capsys):
    """Three commands, each followed by what it prints."""
    done = []
    for (language, code), (_, shown) in zip(BLOCKS[::2], BLOCKS[1::2], strict=True):
        if language == "python":
            exec(code, {})  # noqa: S102 – our own lines
            printed = capsys.readouterr().out
        else:
            assert code.startswith("python -m bench ")
            ended = enter(*shlex.split(code)[3:], output="results/diagnose")
            assert ended.code == 0, ended.err
            printed = ended.out
        require_shown(shown, printed)
        done.append(language)
    assert done == ["sh", "sh", "python"]


def test_the_second_command_is_the_one_that_the_first_prints():
    _, (_, printed), (_, second), *_ = BLOCKS
    assert printed.splitlines()[-1].strip() == second.strip()
