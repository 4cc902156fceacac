"""Open questions of a file for `import`, and the command with a place for each answer.

They are the questions that can be seen in the file.
"""

from __future__ import annotations

import dataclasses
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ksmea.errors import SettingError
from ksmea.settings.settings import own_fields
from measurements.file import File
from measurements.formats.detection import suggested_format
from measurements.formats.lazy_file import Opened
from measurements.formats.questions import Asked, Question, open_questions
from measurements.formats.user_answers import FORMATS
from measurements.formats.waveforms.waveform import MOST_BYTES
from measurements.sweeps import UP

OUT, FORMAT, SWEEP, BOTH = "out", "format", "sweep", "both"
SEVERAL = {"probe": "probes", "column": "columns", "harmonic": "harmonics"}  # an option that may be given several times
PLACE = re.compile(r"[A-Z]")
NAMES = "|".join(field.name for field in own_fields(File))
SETTING = re.compile(rf"(?<![\w.-])(?:measurement\.)?({NAMES})=(?:\[([^\]]*)\]|([^\s;,]+))")


def asked(opened: Opened, given: Mapping[str, Any]) -> Asked[File]:
    """Questions that neither the file nor the options answer; the file is read once.

    Raises `SettingError` if the file does not exist, or the options cannot be used anyway.
    """
    settings = {name: value for name, value in given.items() if name != OUT}
    if settings.get(SWEEP) == BOTH:
        settings[SWEEP] = UP
    found = _of_file(opened, settings) if FORMAT in given else _of_format(opened, settings)
    if OUT in given:
        return found
    said = f"expected where to write what {opened.path} holds, got nothing; give --out run.csv"
    return dataclasses.replace(found, questions=(*found.questions, Question(OUT, said, ("run.csv",), "")))


def _of_file(opened: Opened, settings: Mapping[str, Any]) -> Asked[File]:
    return open_questions(lambda answers: File.of(opened, answers), settings)


def _of_format(opened: Opened, settings: Mapping[str, Any]) -> Asked[File]:
    """The format, and what else is open as far as the file can be read by the one that is suggested."""
    path = opened.path
    suggested = suggested_format(path, opened.content(MOST_BYTES))
    said = f"expected what wrote {path}, got nothing; give --format, one of {', '.join(FORMATS)}"
    unknown_format = Asked[File]((Question(FORMAT, said, ("FORMAT",), None),), is_all=False)
    if suggested is None:
        return unknown_format
    name, by = suggested.name, suggested.because
    try:
        found = _of_file(opened, {**settings, FORMAT: name})
    except SettingError as error:
        said = f"{said}; {by} {name}, and that fails: {str(error).removeprefix(path).lstrip(': ')}"
        return dataclasses.replace(unknown_format, questions=(Question(FORMAT, said, ("FORMAT",), None),))
    question = Question(FORMAT, f"{said}; {by} {name}, check it", (name,), name)
    return Asked((question, *found.questions), found.is_all)


def questions_text(path: str, given: Mapping[str, Any], asked: Asked[File], others: Sequence[str] = ()) -> str:
    """The questions on a file, a line each, and the command that answers them for it and others."""
    count = "1 question is" if len(asked.questions) == 1 else f"{len(asked.questions)} questions are"
    lines = [f"error: import: {count} open:"]
    for each in asked.questions:
        lines.append(f"  {spelt(each.setting)}: {in_options(each.said.removeprefix(path).lstrip(': '))}")
    answers = {each.setting: each.shown for each in asked.questions}
    known = {name: value if isinstance(value, list) else [value] for name, value in given.items()}
    words = [word for name, values in {**known, **answers}.items() if name != OUT for word in _option(name, values)]
    out = _option(OUT, {**known, **answers}[OUT])
    has_places = any(PLACE.search(shown) for shown in _places(asked.questions))
    opening = "All in one command" if asked.is_all else "More may be open once these are answered. The command so far"
    lines.append(opening + (", with your answers in place of words in capitals:" if has_places else ":"))
    return "\n".join([*lines, f"  {shlex.join(['python', '-m', 'bench', 'import', path, *others, *words, *out])}"])


def in_options(said: str) -> str:
    """Settings of an error message, `probes=[name@m@direction,…]`, as options of `import`.

    >>> in_options("give columns=[role=heading,…], or measurement.speed_unit=rpm")
    'give --column role=heading --column …, or --speed-unit rpm'
    """

    def options(found: re.Match[str]) -> str:
        several, one = found[2], found[3]
        return " ".join(_option(found[1], [one] if several is None else several.split(",")))

    return SETTING.sub(options, said)


def _places(questions: Sequence[Question]) -> Iterator[str]:
    """Answers that only the user has, without suggestions of the file."""
    for each in questions:
        yield from () if each.is_suggested else each.shown


def _option(name: str, values: Sequence[Any]) -> Iterator[str]:
    for value in values:
        yield from (spelt(name), f"{value:g}" if isinstance(value, float) else str(value))


def spelt(name: str) -> str:
    """A setting as an option: one of several at a time."""
    single = {setting: option for option, setting in SEVERAL.items()}
    return f"--{single.get(name, name).replace('_', '-')}"
