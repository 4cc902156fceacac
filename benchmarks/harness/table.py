"""The table of a run: a line for each contestant of each row, in a CSV file whose every line says where it was measured."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import pandas as pd

from benchmarks.harness.machine import Machine
from benchmarks.harness.measure import Measured
from benchmarks.harness.pairs import exponent
from benchmarks.harness.row import Row
from ksmea.errors import SettingError

COLUMNS = (
    *("group", "row", "size", "size_of", "contestant", "version", "clock", "turns", "calls", "unit"),
    *("seconds", "seconds_q1", "seconds_q3"),  # of one unit
    *("ratio", "ratio_q1", "ratio_q3"),  # of its seconds over those of the row's first line, paired by turn
    "difference",  # of its values from those of the first line, largest over largest
    *("quality", "quality_of"),  # smaller is better
    *("exponent", "at_least", "no_more_than", "reached", "skipped", "note", "is_quick"),
    *(item.name for item in dataclasses.fields(Machine)),
)
NUMBERS = (
    *("size", "seconds", "seconds_q1", "seconds_q3", "ratio", "ratio_q1", "ratio_q3"),
    *("difference", "quality", "exponent", "at_least", "no_more_than"),
)
TEXTS = ("size_of", "version", "quality_of", "reached", "skipped", "note")
PART = "ratio: its part of the whole"  # the note of a part's line
KEY = ["group", "row", "size", "size_of", "contestant"]


def lines_of(row: Row, found: Sequence[Measured], machine: Machine) -> list[dict[str, object]]:
    """The lines of a row. Parts of a task stand behind it as lines of their own."""
    ours = found[0]
    lines = []
    for each in found:
        line: dict[str, object] = {
            "group": row.group,
            "row": row.name,
            "size": row.size,
            "size_of": row.size_of,
            "unit": row.unit,
            "contestant": each.contestant.name,
            "version": each.version,
            "clock": row.clock,
            "note": each.contestant.note,
            "skipped": each.skipped,
            "is_quick": row.is_quick,
            "quality": each.quality,
            "quality_of": row.quality,
            "difference": each.difference,
            "turns": len(each.seconds),
            "calls": each.calls,
            "at_least": each.contestant.at_least,
            **machine.columns(),
        }
        if each is ours:
            line["no_more_than"] = row.no_more_than
        if each.seconds:
            time = each.time
            line |= {"seconds": time.median, "seconds_q1": time.q1, "seconds_q3": time.q3}
        if each.seconds and each is not ours:
            ratio = each.ratio_to(ours)
            line |= {"ratio": ratio.median, "ratio_q1": ratio.q1, "ratio_q3": ratio.q3}
        lines += [line, *_part_lines(line, each)]
    return lines


def _part_lines(whole: dict[str, object], each: Measured) -> Iterable[dict[str, object]]:
    """What each part takes, its ratio that to the whole."""
    for part in dict.fromkeys(name for parts in each.parts for name in parts):
        seconds = pd.Series([parts.get(part, 0.0) for parts in each.parts])
        share = seconds / pd.Series([sum(parts.values()) for parts in each.parts])
        low, middle, high = seconds.quantile([0.25, 0.5, 0.75])
        yield {
            **{
                name: whole[name]
                for name in ("group", "row", "size", "size_of", "unit", "version", "clock", "turns", "calls")
            },
            **{name: whole[name] for name in (item.name for item in dataclasses.fields(Machine))},
            "contestant": f"{each.contestant.name}: {part}",
            "seconds": middle,
            "seconds_q1": low,
            "seconds_q3": high,
            **dict(zip(("ratio_q1", "ratio", "ratio_q3"), share.quantile([0.25, 0.5, 0.75]), strict=True)),
            "note": PART,
            "is_quick": False,
        }


def table(lines: Sequence[dict[str, object]]) -> pd.DataFrame:
    """All lines, with exponents of what was measured at several sizes, and whether demands are reached."""
    frame = pd.DataFrame(list(lines), columns=list(COLUMNS)).astype(dict.fromkeys(NUMBERS, float))
    frame["reached"] = frame["reached"].astype(object)
    for demand, value, is_lower in (("at_least", "ratio", True), ("no_more_than", "seconds", False)):
        asked = frame[frame[demand].notna() & frame[value].notna()]
        better = asked[value] >= asked[demand] if is_lower else asked[value] <= asked[demand]
        frame.loc[asked.index, "reached"] = better.map({True: "yes", False: "no"})
    return with_texts(_with_exponents(frame))


def write(frame: pd.DataFrame, path: Path) -> None:
    """Whole or not at all; five digits, which is more than any time has."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    frame.to_csv(part, index=False, float_format="%.5g", lineterminator="\n")
    os.replace(part, path)


def read(path: Path) -> pd.DataFrame:
    """A table that was written; `SettingError` where the file is none."""
    if not path.is_file():
        raise SettingError(
            f"{path}: expected a table of `python -m benchmarks`, found no file; make one with --out DIR"
        )
    try:
        frame = pd.read_csv(path)
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise SettingError(f"{path}: expected a table of `python -m benchmarks`, got {error}") from None
    lacking = [name for name in (*KEY, "seconds", "ratio", *TEXTS) if name not in frame]
    if lacking:
        raise SettingError(
            f"{path}: expected the columns {', '.join(lacking)} too; make it with `python -m benchmarks`"
        )
    return with_texts(frame)


def with_texts(frame: pd.DataFrame) -> pd.DataFrame:
    """With empty texts where a file has nothing, and not a number for numbers alone."""
    return frame.assign(**{name: frame[name].astype(object).where(frame[name].notna(), "") for name in TEXTS})


def machines(frame: pd.DataFrame) -> list[Machine]:
    """All that lines were measured on, in their order."""
    names = [item.name for item in dataclasses.fields(Machine)]
    return [Machine(*each) for each in frame[names].drop_duplicates().itertuples(index=False, name=None)]


def merged(old: pd.DataFrame, new: pd.DataFrame) -> pd.DataFrame:
    """The old table with those rows replaced or added that the new one has, at the sizes that it has them."""
    fresh = set(_rows_of(new))
    kept = old[[row not in fresh for row in _rows_of(old)]]
    return new if kept.empty else _with_exponents(pd.concat([kept, new], ignore_index=True))


def _rows_of(frame: pd.DataFrame) -> Iterable[tuple[object, ...]]:
    """The row that each line is of, without a size as with the size none."""
    named = frame[["group", "row", "size_of"]].assign(
        size=frame["size"].astype(object).where(frame["size"].notna(), None)
    )
    return named.itertuples(index=False, name=None)


def _with_exponents(frame: pd.DataFrame) -> pd.DataFrame:
    """Of the series that have three sizes or more."""
    exponents = pd.Series(float("nan"), index=frame.index)
    for _, series in frame.groupby(["group", "row", "size_of", "contestant"], sort=False, dropna=False):
        timed = series[series["seconds"].notna() & series["size"].notna()]
        if timed["size"].nunique() >= 3:
            exponents[timed.index] = exponent(timed["size"].to_numpy(float), timed["seconds"].to_numpy(float))
    return frame.assign(exponent=exponents)
