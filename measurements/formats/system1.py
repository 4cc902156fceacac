"""Bode exports of Bently Nevada System 1: CSV with lines `name,value`, then a table.

    Machine Name,STG-10
    Point Name,VX-1X (VERTICAL)
    Comp,
    Probe Angle,45° Right
    X-Axis Unit,rpm
    Y-Axis Unit,mil pp
    Variable,1X
    X-Axis Value,Y-Axis Value,Y-Axis Status,Phase,Phase Status,Timestamp
    234,0.217,Valid,47,Valid,4/4/2021 4:35:40 AM

Synchronous waveforms have other columns below the same first lines (`waveforms/system1_waveform.py`).

Versions differ in which of the first lines there are, in whether there are columns of status, and in whether one file has several
points one below the other. All of them are read by the names of lines and columns. Phases are lags, as Bently Nevada's
instruments show them (Bently & Hatch, Fundamentals of Rotating Machinery Diagnostics, 2002, chapter 2). A row whose status is not
Valid is left out, and so is one that is the same as the one before. `Comp` or `Compensation` says whether slow roll is subtracted.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ksmea.errors import SettingError, shortened
from measurements.formats.curve import Curve
from measurements.formats.texts import SEPARATORS, has_decimal_commas, number, rows_of_cells, text_of
from measurements.formats.timestamps import seconds
from measurements.formats.user_answers import Answers
from measurements.formats.waveforms.system1_waveform import Export, is_waveform, waveform_curves
from measurements.run_up_rows import MAX_ROWS

SPEED, AMPLITUDE, PHASE = "x-axis value", "y-axis value", "phase"
STATUSES = ("y-axis status", "phase status", "x-axis status", "status")
TIME = "timestamp"
KNOWN = (SPEED, AMPLITUDE, PHASE, *STATUSES, TIME)
HARMONIC = re.compile(r"(?<![0-9.])([0-9]+\.?[0-9]*)\s*x\b", re.IGNORECASE | re.ASCII)
NOT_COMPENSATED = ("", "none", "no", "off", "false", "uncompensated", "0")


@dataclass
class _Block:
    """One point of the file while it is read: what its first lines say, and its table."""

    named: dict[str, str] = field(default_factory=dict)
    columns: list[str] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)


def read_system1(content: bytes, answers: Answers) -> list[Curve]:
    """The points of an export.

    Raises `SettingError`, with the line if there is one at fault, if the text is not such an export.
    """
    path, text = answers.path, text_of(content, answers.path)
    separator = _separator(text)
    if separator is None:
        raise SettingError(
            f"{path}: expected a System 1 Bode export with the columns X-Axis Value, Y-Axis Value, Phase, got none; name the format"
            " of the file"
        )
    blocks = _blocks(text, separator, path)
    if not any(block.rows for block in blocks):
        raise SettingError(f"{path}: expected rows below X-Axis Value, Y-Axis Value, got none")
    filled = [block for block in blocks if block.rows]
    waves = [block for block in filled if is_waveform(block.named.get("variable", ""))]
    curves = [_curve(block, path) for block in filled if block not in waves]
    if waves and answers.phase in ("lag", "lead"):
        raise SettingError(f"phase: expected none with waveforms, whose phases are computed here, got {answers.phase}")
    exports = [Export(block.named, block.lines[0], _samples(block, path)) for block in waves]
    return [*(curve for curve in curves if curve is not None), *waveform_curves(exports, answers.harmonics, path)]


def _samples(block: _Block, path: str) -> np.ndarray:
    at = block.columns.index(AMPLITUDE)
    cells = [row[at] for row in block.rows]
    comma = has_decimal_commas(cells, path)
    values = [number(cell, f"{path} line {line}", decimal_comma=comma) for cell, line in zip(cells, block.lines)]
    if not np.all(np.isfinite(values)):
        raise SettingError(
            f"{path} line {block.lines[0]}: expected a number in each sample, got none in some; export it again"
        )
    return np.array(values)


def is_system1(text: str) -> bool:
    """Whether a text has the header of such an export."""
    return _separator(text) is not None


def _separator(text: str) -> str | None:
    return next((each for each in SEPARATORS if _has_header(text, each)), None)


def _has_header(text: str, separator: str) -> bool:
    return any(
        {SPEED, AMPLITUDE} <= {cell.strip(' "').lower() for cell in line.split(separator)} for line in text.splitlines()
    )


def _blocks(text: str, separator: str, path: str) -> list[_Block]:
    blocks = [_Block()]
    n_row = 0
    for line, cells in rows_of_cells(text, separator, path):
        lowered = [cell.lower() for cell in cells]
        if SPEED in lowered and AMPLITUDE in lowered:
            if blocks[-1].columns:
                raise SettingError(f"{path} line {line}: expected Point Name before a further table, got none")
            blocks[-1].columns = _columns(lowered, f"{path} line {line}")
        elif blocks[-1].columns and _is_named(cells, blocks[-1]):
            if blocks[-1].rows:  # the next point begins
                blocks.append(_Block())
            blocks[-1].named[lowered[0]] = cells[1] if len(cells) > 1 else ""
        elif blocks[-1].columns:
            n_row += not is_waveform(blocks[-1].named.get("variable", ""))
            if n_row > MAX_ROWS:
                raise SettingError(f"{path} line {line}: expected at most {MAX_ROWS} rows, got more; thin them out")
            _add(blocks[-1], line, cells, path)
        else:
            if lowered[0] in blocks[-1].named:
                raise SettingError(f"{path} line {line}: expected {shortened(cells[0])} once, got it again; remove one")
            blocks[-1].named[lowered[0]] = separator.join(cells[1:]).strip(separator)
    return blocks


def _columns(names: Sequence[str], where: str) -> list[str]:
    for name in KNOWN:
        if names.count(name) > 1:
            raise SettingError(f"{where}: expected each column once, got {name} {names.count(name)} times; remove one")
    return list(names)


def _is_named(cells: Sequence[str], block: _Block) -> bool:
    """Whether a line below a table is a line `name,value` of the next point."""
    return len(cells) <= 2 <= len(block.columns) and bool(re.match(r"[A-Za-z]", cells[0]))


def _add(block: _Block, line: int, cells: list[str], path: str) -> None:
    n_column = len(block.columns)
    if len(cells) > n_column and not any(cells[n_column:]):
        cells = cells[:n_column]
    if len(cells) != n_column:
        raise SettingError(f"{path} line {line}: expected {n_column} cells as in the header, got {len(cells)}")
    block.lines.append(line)
    block.rows.append(cells)


def _curve(block: _Block, path: str) -> Curve | None:
    """The curve of a point; None if its variable is not a harmonic, such as the overall amplitude."""
    named = block.named
    name = named.get("point name", "")
    variable = named.get("variable", "1X")
    found = HARMONIC.search(variable)
    if found is None:
        if variable.strip().lower() in ("direct", "overall", "gap", "notx", "not 1x"):
            return None
        raise SettingError(f"{path}: expected Variable 1X, 2X and so on, got {shortened(repr(variable))}")
    harmonic = float(found[1])
    if not 0 < harmonic <= 100:
        raise SettingError(f"{path}: expected Variable from 0.1X to 100X, got {shortened(repr(variable))}")
    at = {column: index for index, column in enumerate(block.columns)}
    numeric = [
        cell for row in block.rows for column in (SPEED, AMPLITUDE, PHASE) if column in at for cell in [row[at[column]]]
    ]
    comma = has_decimal_commas(numeric, path)
    status = [all(row[at[each]].lower() in ("valid", "") for each in STATUSES if each in at) for row in block.rows]
    again = [index > 0 and row == block.rows[index - 1] for index, row in enumerate(block.rows)]

    def column(which: str) -> np.ndarray:
        return np.array(
            [
                number(row[at[which]], f"{path} line {line}", decimal_comma=comma) if valid else np.nan
                for row, line, valid in zip(block.rows, block.lines, status)
            ]
        )

    curve = Curve(
        name,
        "",
        block.lines,
        column(SPEED),
        column(AMPLITUDE),
        phase=column(PHASE) if PHASE in at else None,
        time=seconds([row[at[TIME]] for row in block.rows]) if TIME in at else None,
        speed_unit=named.get("x-axis unit", ""),
        unit=named.get("y-axis unit", ""),
        sense="lag",
        angle=named.get("probe angle", ""),
        harmonic=harmonic,
        is_compensated=_is_compensated(named),
    )
    return curve.rows(np.array(status), "not valid").rows(~np.array(again)[np.array(status)], "twice")


def _is_compensated(named: dict[str, str]) -> bool:
    said = next((named[each] for each in ("comp", "compensation", "compensated") if each in named), "")
    return said.strip().lower() not in NOT_COMPENSATED
