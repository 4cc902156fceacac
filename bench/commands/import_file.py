"""`import FILE --format FORMAT … --out RUN.csv`: an instrument's file, or a table, as project CSV.

Options are the settings of `measurement=file` by their names, `--slow-roll 300` or `slow_roll=300`; `--probe` and
`--column` may be given several times. Decisions about the file stand in remarks at its head, and the same settings read
the file directly. Several files are records at steady speeds, which become one run (`--vectors mean`). `--sweep both`
writes the run-up and the coast-down to separate files, with a YAML file for `measurement=campaign`.
"""

from __future__ import annotations

import json
import re
import sys
import typing
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from bench.commands.import_questions import BOTH, OUT, SEVERAL, asked, questions_text, spelt
from bench.storage.files import replace_file
from ksmea.errors import SettingError, unknown, visible, visible_lines
from ksmea.settings.settings import own_fields
from ksmea.settings.types import read_as
from measurements.file import File
from measurements.formats.lazy_file import Opened
from measurements.formats.probe_positions import CLOCKWISE
from measurements.formats.user_answers import OWN
from measurements.formats.waveforms.steady import MEAN
from measurements.joined import joined
from measurements.run_up_csv import rows_as_csv
from measurements.slow_roll import SUBTRACTED
from measurements.sweeps import DOWN, UP

UNANSWERED = 2  # exit code
OF_MODELS = (".toml", ".json")  # which no instrument writes
NOT_OF_A_NAME = re.compile(r"[^\w.-]+")  # of a run


def import_file(words: list[str]) -> int:
    """Write what a file holds, and print what was decided of it."""
    (path, *others), given = _options(words)
    if Path(path).suffix.lower() in OF_MODELS:
        raise SettingError(
            f"import: expected a file of a measurement, got {path}; a model of a rotor is imported by: import rotor {path}",
        )
    opened = Opened(path, keeps=True)
    if OUT in given:
        _require_new(Path(given[OUT]), given)
    try:
        found = asked(opened, given)
    except SettingError as error:
        raise SettingError(f"import: {error}") from error
    if found.questions:
        print(visible_lines(questions_text(path, given, found, others)), file=sys.stderr)
        return UNANSWERED
    out = Path(given.pop(OUT))
    if others:
        return _import_records(found.source, [_source(Opened(each), given) for each in others], out, given)
    both = given.get("sweep") == BOTH
    parts = (UP, DOWN) if both else (given.get("sweep"),)
    outs, campaign = _written(out, given)[: len(parts)], out.with_suffix(".yaml")
    settings = [{**given, **({"sweep": part} if part else {})} for part in parts]
    assert found.source is not None, "nothing is open"
    sources = [found.source, *(_source(opened, each) for each in settings[1:])]  # all are read before any is written
    out.parent.mkdir(parents=True, exist_ok=True)
    for source, target, chosen in zip(sources, outs, settings):
        replace_file(target, rows_as_csv(source.used_rows, _head(source, chosen)).encode())
        _tell(source, target)
    if both:
        runs = "".join(
            f"  - {{name: {NOT_OF_A_NAME.sub('_', target.stem)}, file: {json.dumps(target.name, ensure_ascii=False)}, direction: {part}}}\n"  # a name may have commas
            for part, target in zip(parts, outs)
        )
        replace_file(
            campaign, f"# {visible(Path(path).name)}, split where its speed turns back\nruns:\n{runs}".encode()
        )
        print(f"written: {visible(str(campaign))} (measurement=campaign)")
    return 0


def _import_records(first: File | None, others: Sequence[File], out: Path, given: dict[str, Any]) -> int:
    """Write the rows of several files as one run."""
    assert first is not None, "nothing is open"
    rows, remarks = joined([first, *others])
    head = [*_head(first, given, ", ".join(Path(each.path).name for each in (first, *others))), *remarks]
    out.parent.mkdir(parents=True, exist_ok=True)
    replace_file(out, rows_as_csv(rows, dict.fromkeys(map(visible, head))).encode())
    print(f"written: {visible(str(out))}: {len(set(rows.speed))} speeds from {len(others) + 1} files")
    for remark in remarks:
        print(f"  {visible(remark)}")
    return 0


def _written(out: Path, given: Mapping[str, Any]) -> list[Path]:
    """The files that are written: of a sweep both ways two, and the campaign of them."""
    if given.get("sweep") != BOTH:
        return [out]
    return [*(out.with_name(f"{out.stem}_{part}{out.suffix}") for part in (UP, DOWN)), out.with_suffix(".yaml")]


def _require_new(out: Path, given: Mapping[str, Any]) -> None:
    if out.suffix == "":
        raise SettingError(f"import: expected --out with a file name such as run.csv, got {out}")
    for each in _written(out, given):
        if each.exists():
            raise SettingError(f"import: expected no {each} yet, found one; choose another --out, or remove it")


def _source(opened: Opened, settings: dict[str, Any]) -> File:
    try:
        return File.of(opened, settings)
    except SettingError as error:
        raise SettingError(f"import: {error}") from error


def _tell(source: File, target: Path) -> None:
    data = source.read()
    rpm = [min(source.used_rows.speed), max(source.used_rows.speed)]
    channels = ", ".join(map(str, data.channels))
    speeds = f"{len(data.speed)} speeds from {rpm[0]:g} to {rpm[1]:g} rpm" if rpm[0] < rpm[1] else f"{rpm[0]:g} rpm"
    print(f"written: {visible(str(target))}: {speeds}; {channels}")
    for remark in source.remarks:
        print(f"  {visible(remark)}")


def _head(source: File, settings: dict[str, Any], files: str = "") -> Iterator[str]:
    """The remarks of a written file.

    They state what was decided, so that nothing is asked or done twice.
    """
    yield visible(f"Imported from {files or Path(source.path).name}, format {source.format}.")
    yield "Units: rpm; m from the left end; µm zero to peak; degrees of phase lead; s. Directions: x, y, degrees from x to y."
    yield visible(source.notation.line())
    if source.format != OWN:
        yield f"rotation: {_rotation(source)}"
    if not any(remark.startswith(SUBTRACTED) for remark in source.remarks):
        yield "slow roll: not subtracted by this import"
    asked = " ".join(f"{name}={value}" for name, value in settings.items() if name not in ("format", "path"))
    if asked:
        yield visible(f"settings: {asked}")
    if not files:  # of several each has its own
        yield from map(visible, source.remarks)


def _rotation(source: File) -> str:
    if source.rotation is None:
        return "from x to y, as probes are given"
    return "clockwise; x of the model is to the left" if source.rotation == CLOCKWISE else "counterclockwise"


def _options(words: Sequence[str]) -> tuple[list[str], dict[str, Any]]:
    """The files and the settings that words give them."""
    hints = typing.get_type_hints(File)
    known = {field.name: hints[field.name] for field in own_fields(File) if field.name != "path"}
    files: list[str] = []
    given: dict[str, Any] = {}
    remaining = iter(words)
    for word in remaining:
        name, separator, value = word.partition("=")
        option = name.lstrip("-").replace("-", "_")
        if not word.startswith("--") and (not separator or option not in (*known, *SEVERAL, OUT)):
            files.append(word)
            continue
        if option not in (*known, *SEVERAL, OUT):
            raise unknown("option of import:", name, dict.fromkeys(spelt(each) for each in (OUT, *known)))
        if not separator:
            value = next(remaining, "")
        if not value:
            raise SettingError(f"import: expected a value after {name}, got nothing")
        key = SEVERAL.get(option, option)
        if option in SEVERAL:
            given.setdefault(key, []).append(value)
        elif key in given:
            raise SettingError(f"import: expected {name} once, got it again; leave one out")
        else:
            given[key] = [part.strip() for part in value.strip("[]").split(",")] if _is_list(key, known) else value
    is_steady = given.get("vectors") == MEAN or given.get("format") == "system1"
    if not files or (len(files) > 1 and (not is_steady or given.get("sweep") == BOTH)):
        raise SettingError(
            f"import: expected one file, got {len(files)}: import FILE --format FORMAT --out run.csv; several are records at steady"
            " speeds, of --format system1 or with --vectors mean"
        )
    return files, {key: _as_setting(key, value, known) for key, value in given.items()}


def _is_list(key: str, known: dict[str, Any]) -> bool:
    return key in known and typing.get_origin(known[key]) is list


def _as_setting(key: str, value: Any, known: dict[str, Any]) -> Any:
    """A text, or several, as the setting has it."""
    if key == OUT or (key == "sweep" and value == BOTH):
        return value
    try:
        return read_as(_plain(value, known[key]), known[key])
    except SettingError as error:
        raise SettingError(f"import: --{spelt(key).lstrip('-')}: {error}") from error


def _plain(value: Any, hint: Any) -> Any:
    """Convert texts of numbers to numbers if the setting takes numbers and no text."""
    options = typing.get_args(hint) or (hint,)
    if str in options:
        return value
    if isinstance(value, list):
        return [_plain(each, float) for each in value]
    try:
        number = float(value)
    except ValueError:
        return value
    return int(number) if int in options and number.is_integer() else number
