"""What a file leaves open that `import` is to read: all of it at once, and the command with a place for each answer."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ksmea.errors import SettingError
from measurements.file import File
from measurements.formats.answers import FORMATS
from measurements.formats.questions import Question, open_questions
from measurements.sweeps import UP

OUT, FORMAT, SWEEP, BOTH = "out", "format", "sweep", "both"
SEVERAL = {"probe": "probes", "column": "columns", "harmonic": "harmonics"}  # an option that may be given several times
PLACE = re.compile(r"[A-Z]")
ENDINGS = {".csv": "csv", ".txt": "csv", ".xlsx": "excel", ".mat": "mat", ".uff": "uff", ".unv": "uff"}


def asked(path: str, given: Mapping[str, Any]) -> list[Question]:
    """What neither the file nor the options say. Raises `SettingError` where the options cannot be used anyway."""
    settings = {name: value for name, value in given.items() if name != OUT}
    if settings.get(SWEEP) == BOTH:
        settings[SWEEP] = UP
    found = []
    if FORMAT not in given:
        said = f"expected what wrote {path}, got nothing; give --format, one of {', '.join(FORMATS)}"
        likely = ENDINGS.get(Path(path).suffix.lower())
        found.append(Question(FORMAT, said, (likely or "FORMAT",), likely))
    found += _of_file(path, settings, found)
    if OUT not in given:
        found.append(
            Question(
                OUT, f"expected where to write what {path} holds, got nothing; give --out run.csv", ("run.csv",), ""
            )
        )
    return found


def _of_file(path: str, settings: Mapping[str, Any], of_format: Sequence[Question]) -> list[Question]:
    """What the file itself leaves open; with a format that is only likely, as far as it can be read by that."""

    def read(answers: Mapping[str, Any]) -> File:
        return File(path=path, **answers)

    if not of_format:
        return open_questions(read, settings)
    if of_format[0].meanwhile is None:
        return []
    try:
        return open_questions(read, {**settings, FORMAT: of_format[0].meanwhile})
    except SettingError:
        return []


def questions_text(path: str, given: Mapping[str, Any], questions: Sequence[Question]) -> str:
    """The questions, a line each, and the command that answers them."""
    count = "1 question is" if len(questions) == 1 else f"{len(questions)} questions are"
    lines = [f"error: import: {count} open:"]
    for each in questions:
        lines.append(f"  {spelt(each.setting)}: {each.said.removeprefix(path).lstrip(': ')}")
    answers = {each.setting: each.shown for each in questions}
    known = {name: value if isinstance(value, list) else [value] for name, value in given.items()}
    words = [word for name, values in {**known, **answers}.items() if name != OUT for word in _option(name, values)]
    out = [word for word in _option(OUT, {**known, **answers}[OUT])]
    has_places = any(PLACE.search(shown) for shown in _places(questions))
    lines.append("All in one command" + (", with your answers in place of words in capitals:" if has_places else ":"))
    return "\n".join([*lines, f"  {shlex.join(['python', '-m', 'bench', 'import', path, *words, *out])}"])


def _places(questions: Sequence[Question]) -> Iterator[str]:
    """Answers that only the user has; columns that are suggested are none."""
    for each in questions:
        yield from () if each.setting == "columns" and each.meanwhile else each.shown


def _option(name: str, values: Sequence[Any]) -> Iterator[str]:
    for value in values:
        yield from (spelt(name), f"{value:g}" if isinstance(value, float) else str(value))


def spelt(name: str) -> str:
    """A setting as an option: one of several at a time."""
    single = {setting: option for option, setting in SEVERAL.items()}
    return f"--{single.get(name, name).replace('_', '-')}"
