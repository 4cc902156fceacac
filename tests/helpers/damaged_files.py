"""Damaged files as strategies of Hypothesis, and the outcome of reading them.

A healthy file has one to three slips of a pen, an editor, a spreadsheet or a disk; it is read within limits of time and
memory.

    python -m pytest tests/bench/test_damaged_files.py tests/bench/test_damaged_imports.py --hypothesis-profile=long

tries 2000 files of each kind instead of 60, others at each call, and reads each in a process of its own. What fails is made as small
as it can be, and printed with what makes it again.
"""

import contextlib
import io
import json
import os
import re
import resource
import select
import signal
import traceback
import unicodedata
from dataclasses import dataclass

from hypothesis import settings
from hypothesis import strategies as st

from ksmea.errors import SettingError

IS_LONG = settings.default.max_examples > settings.get_profile("short").max_examples
SECONDS, BYTES = 25, 2 * 2**30
LONGEST_DETAIL = 3000  # characters that are kept, from the end
MOST_SLIPS = 3
FAULTS = ("traceback", "hang", "memory", "control characters", "several lines", "died", "silently wrong")
HIDDEN = ("Cc", "Cf", "Zl", "Zp", "Cs")  # categories of characters that no terminal should get


@st.composite
def damaged(draw, content, slips):
    """The content after one to three slips, each a function of `draw` and of the content."""
    for slip in draw(st.lists(st.sampled_from(slips), min_size=1, max_size=MOST_SLIPS)):
        content = slip(draw, content)
    return content


def _place(draw, content):
    return draw(st.integers(0, len(content)))


def other_byte(draw, content):
    at = _place(draw, content)
    return content[:at] + draw(st.binary(min_size=1, max_size=1)) + content[at + draw(st.integers(0, 1)) :]


def cut(draw, content):
    at = _place(draw, content)
    return content[:at] + content[at + draw(st.sampled_from((1, 5, 50, 500))) :]


def truncated(draw, content):
    return content[: _place(draw, content)]


def other_line(draw, content):
    """One line is left out, stands twice or elsewhere."""
    lines = content.splitlines(keepends=True) or [b""]
    line = draw(st.sampled_from(lines))
    change = draw(st.sampled_from(("left out", "twice", "elsewhere")))
    if change != "twice":
        lines.remove(line)
    if change != "left out":
        lines.insert(_place(draw, lines), line)
    return b"".join(lines)


def swapped(draw, content):
    """Two cells of one line change places."""

    def change(cells):
        first, second = (draw(st.sampled_from(range(len(cells)))) for _ in "12")
        cells[first], cells[second] = cells[second], cells[first]

    return _in_one_line(draw, content, change)


def other_cell(tokens):
    """One cell of a table is another of the tokens."""

    def slip(draw, content):
        def change(cells):
            cells[draw(st.sampled_from(range(len(cells))))] = draw(st.sampled_from(tokens))

        return _in_one_line(draw, content, change)

    return slip


def _in_one_line(draw, content, change):
    lines = content.split(b"\n")
    at = draw(st.sampled_from(range(len(lines))))
    separator = next((each for each in (b";", b"\t", b"|", b",") if each in lines[at]), b" ")
    cells = lines[at].split(separator)
    change(cells)
    lines[at] = separator.join(cells)
    return b"\n".join(lines)


def other_value(tokens):
    """One value or key of a YAML file is another of the tokens."""

    def slip(draw, content):
        spans = [found.span() for found in re.finditer(rb"(?<=[ \[,{-])\w[^,}\]\n:]*", content)]
        start, end = draw(st.sampled_from(spans or [(0, 0)]))
        return content[:start] + draw(st.sampled_from(tokens)) + content[end:]

    return slip


def inserted(tokens):
    def slip(draw, content):
        at = _place(draw, content)
        return content[:at] + draw(st.sampled_from(tokens)) + content[at:]

    return slip


def recoded(draw, content):
    for encoding in ("utf-8", "utf-16", "latin-1"):
        with contextlib.suppress(UnicodeError):
            other = draw(st.sampled_from(("utf-16", "utf-8", "latin-1", "utf-32", "cp500")))
            return content.decode(encoding).encode(other, "replace")
    return content


def other_json(values, keys):
    """JSON lines in which one value is another, is missing or is too many.

    Shallow ones are as likely as deep ones.
    """

    def slip(draw, content):
        lines = content.splitlines()
        at = draw(st.one_of(st.just(0), st.sampled_from(range(len(lines)))))  # heads and cells are few, runs are many
        try:
            data = inside = json.loads(lines[at])
        except ValueError:  # an earlier slip was here
            return content
        while inside and isinstance(inside, (dict, list)):
            key = draw(st.sampled_from(list(inside) if isinstance(inside, dict) else range(len(inside))))
            if isinstance(inside[key], (dict, list)) and inside[key] and draw(st.integers(1, 10)) <= 7:
                inside = inside[key]
                continue
            change = draw(st.sampled_from(("missing", "too many", *["another"] * 5)))
            if change == "missing":
                del inside[key]
            elif change == "too many" and isinstance(inside, dict):
                inside[draw(st.sampled_from(keys))] = draw(st.sampled_from(values))
            else:
                inside[key] = draw(st.sampled_from(values))
            break
        lines[at] = json.dumps(data).encode()
        return b"\n".join(lines) + b"\n"

    return slip


@dataclass(frozen=True)
class Outcome:
    """Outcome of reading a file: `fine`, `refused` and the like, or a fault.

    `detail` is its last words.
    """

    ending: str
    detail: str = ""


def outcome_of(read):
    """Outcome of reading: `read` returns an `Outcome` or None.

    A refusal is one line, and nothing is printed that no terminal should get.
    """
    return _isolated(lambda: _outcome(read)) if IS_LONG else _outcome(read)


def _outcome(read):
    printed, refusal, found = io.StringIO(), "", None
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            found = read()
    except SettingError as error:
        refusal = str(error)
    except MemoryError:
        return Outcome("memory", traceback.format_exc())
    except Exception:
        return Outcome("traceback", traceback.format_exc())
    shown = printed.getvalue() + refusal
    if bad := [sign for sign in shown if sign != "\n" and unicodedata.category(sign) in HIDDEN]:
        return Outcome("control characters", f"{bad[0]!r} in {shown[:2000]!r}")
    if refusal:
        return Outcome("several lines" if "\n" in refusal else "refused", refusal)
    return found or Outcome("fine")


def _isolated(trial):
    """The outcome of a trial in a process of its own.

    `hang` past so many seconds, `died` where it ends without one.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        outcome = trial()
        with open(writing, "w") as pipe:
            json.dump([outcome.ending, outcome.detail[-LONGEST_DETAIL:]], pipe)
        os._exit(0)
    os.close(writing)
    with open(reading) as pipe:
        ready = select.select([pipe], [], [], SECONDS)[0]
        if not ready:
            os.kill(child, signal.SIGKILL)
        answer = pipe.read() if ready else ""
    _, code = os.waitpid(child, 0)
    if not ready:
        return Outcome("hang", f"more than {SECONDS} s")
    return Outcome(*json.loads(answer)) if answer else Outcome("died", f"signal or code {code}")
