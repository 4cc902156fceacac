"""Table of a run: a line for each contestant of each row, in a CSV file.

Every line states where it was measured.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from bench.storage.files import replace_file
from benchmarks.harness.machine import MACHINE
from benchmarks.harness.measure import Measured, exponent, quartiles
from benchmarks.harness.row import Row
from ksmea.errors import SettingError

SECONDS = ("seconds_q1", "seconds", "seconds_q3")  # of one unit
RATIO = ("ratio_q1", "ratio", "ratio_q3")  # of its seconds over those of the row's first line, paired by turn
COLUMNS = (
    *("group", "row", "size", "size_of", "contestant", "version", "clock", "turns", "calls", "unit"),
    *("seconds", "seconds_q1", "seconds_q3", "ratio", "ratio_q1", "ratio_q3"),
    "difference",  # of its values from those of the first line, largest over largest
    *("quality", "quality_of", "failed"),  # smaller is better; turns whose quality is no better than a mean's
    *("exponent", "at_least", "no_more_than", "reached", "skipped", "note", "is_quick"),
    *MACHINE,
)
NUMBERS = ("size", *SECONDS, *RATIO, "difference", "quality", "failed", "exponent", "at_least", "no_more_than")
TEXTS = ("size_of", "version", "quality_of", "reached", "skipped", "note")
PART = "ratio: its part of the whole"  # the note of a part's line
KEY = ["group", "row", "size", "size_of", "contestant"]
FALLEN = 2 / 3  # of the committed ratio

Line = dict[str, Any]


def lines_of(row: Row, found: Sequence[Measured], machine: Mapping[str, object]) -> list[Line]:
    """The lines of a row. Parts of a task stand behind it as lines of their own."""
    ours = found[0]
    lines = []
    for each in found:
        line: Line = {name: getattr(row, name) for name in ("group", "size", "size_of", "unit", "clock")}
        line |= {"row": row.name, "turns": len(each.seconds), "calls": each.calls, "version": each.version, **machine}
        whole = line | {"contestant": each.contestant.name, "note": each.contestant.note, "is_quick": row.is_quick}
        whole |= {"skipped": each.skipped, "difference": each.difference, "at_least": each.contestant.at_least}
        whole |= {"quality": each.quality, "quality_of": row.quality, "failed": each.failed(row.failed_above)}
        if each.seconds:
            whole |= zip(SECONDS, quartiles(each.seconds))
        if each is ours:
            whole["no_more_than"] = row.no_more_than
        elif each.seconds:
            whole |= zip(RATIO, each.ratio_to(ours))
        lines += [whole, *_part_lines(line, each)]
    return lines


def _part_lines(line: Line, each: Measured) -> Iterable[Line]:
    """Time of each part, its ratio to the whole."""
    for part in dict.fromkeys(name for parts in each.parts for name in parts):
        seconds = [parts.get(part, 0.0) for parts in each.parts]
        share = [mine / sum(parts.values()) for mine, parts in zip(seconds, each.parts)]
        of_part = {"contestant": f"{each.contestant.name}: {part}", "note": PART, "is_quick": False}
        yield line | of_part | dict(zip((*SECONDS, *RATIO), (*quartiles(seconds), *quartiles(share))))


def table(lines: Sequence[Line]) -> pd.DataFrame:
    """All lines, with exponents of what was measured at several sizes, and whether demands are reached."""
    frame = pd.DataFrame(list(lines), columns=list(COLUMNS)).astype(dict.fromkeys(NUMBERS, float))
    frame["reached"] = frame["reached"].astype(object)
    for demand, value, is_lower in (("at_least", "ratio", True), ("no_more_than", "seconds", False)):
        asked = frame[frame[demand].notna() & frame[value].notna()]
        better = asked[value] >= asked[demand] if is_lower else asked[value] <= asked[demand]
        frame.loc[asked.index, "reached"] = better.map({True: "yes", False: "no"})
    return _with_texts(_with_exponents(frame))


def write(frame: pd.DataFrame, path: Path) -> None:
    """Whole or not at all; five digits, which is more than any time has."""
    path.parent.mkdir(parents=True, exist_ok=True)
    replace_file(path, frame.to_csv(index=False, float_format="%.5g", lineterminator="\n").encode())


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
    return _with_texts(frame)


def merged(old: pd.DataFrame, new: pd.DataFrame) -> pd.DataFrame:
    """The old table with those rows replaced or added that the new one has, at the sizes that it has them."""
    kept = old[~_row_keys(old).isin(_row_keys(new))]
    return new if kept.empty else _with_exponents(pd.concat([kept, new], ignore_index=True))


def same_ratios(now: pd.DataFrame, committed: pd.DataFrame) -> pd.DataFrame:
    """Ratios that both tables have; a row without a size meets one without."""
    measured = now.loc[now["ratio"].notna(), [*KEY, "ratio", "ratio_q3"]]
    known = committed[committed["ratio"].notna()]
    without = {"size": -1.0}
    both = known.fillna(without).merge(measured.fillna(without), on=KEY, suffixes=("", "_now"))
    return both.assign(size=both["size"].where(both["size"] >= 0))


def fallen(both: pd.DataFrame) -> pd.DataFrame:
    """Ratios whose third quartile now is below two thirds of the committed median.

    Lines to look at, not errors, since ratios still depend on the processor.
    """
    return both[both["ratio_q3_now"] < FALLEN * both["ratio"]]


def _with_texts(frame: pd.DataFrame) -> pd.DataFrame:
    """With empty texts where a file has nothing, and not a number for numbers alone."""
    return frame.assign(**{name: frame[name].astype(object).where(frame[name].notna(), "") for name in TEXTS})


def _row_keys(frame: pd.DataFrame) -> pd.Series:
    """The row that each line is of, without a size as with the size none."""
    return frame[["group", "row", "size_of", "size"]].fillna({"size": -1.0}).apply(tuple, axis=1)


def _with_exponents(frame: pd.DataFrame) -> pd.DataFrame:
    """Of the series that have three sizes or more."""
    exponents = pd.Series(float("nan"), index=frame.index)
    for _, series in frame.groupby(["group", "row", "size_of", "contestant"], sort=False, dropna=False):
        timed = series[series["seconds"].notna() & series["size"].notna()]
        if timed["size"].nunique() >= 3:
            exponents[timed.index] = exponent(timed["size"].to_numpy(float), timed["seconds"].to_numpy(float))
    return frame.assign(exponent=exponents)
