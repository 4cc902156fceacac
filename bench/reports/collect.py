"""From plan and records alone: tables, figures and the exit code."""

from __future__ import annotations

import hashlib
import os
import sys
import traceback
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from bench.jobs.lines import RESULTS
from bench.jobs.processors import counted_processors, mixed_processors, processors
from bench.jobs.records import NOT_FAILED, RUNNING, UNFINISHED, damage_notes, last_began
from bench.plan.plan import Plan, read_plan
from bench.plan.report import Drawing, Made, report_named
from bench.reports.pages.experiment import PAGE, experiment_page
from bench.reports.pages.index import write_index_above
from bench.reports.runs import without_class
from bench.storage.files import remove_partial, replace_file
from ksmea.errors import SettingError, shortened, visible, visible_lines
from ksmea.numerics.parallel import available_cores, for_each
from ksmea.settings.regular_files import open_regular
from ksmea.show.charts.chart import Chart

LONGEST_NOTE = 1000  # characters
LONGEST_REASON = 500  # characters of why a run failed
DRAWN = ".drawn"  # holds a digest of what the figures beside it were drawn from


def collect(output: Path, redraw: bool = True) -> int:
    """Write and print what the records of an experiment say.

    Returns 0 if every planned run has a result, else 1, also if its report cannot be made: files written before then
    stay.

    Without `redraw`, figures and page that were drawn from the same tables by the same code are left as they are.
    """
    plan = read_plan(output)
    remove_partial(output)
    report = report_named(plan.report.table)
    try:
        made = report.make(plan, output)
    except (SettingError, OSError):
        raise
    except Exception as error:  # whatever a report of other people raises
        if os.environ.get("BENCH_TRACEBACK"):
            traceback.print_exc()
        message = (
            f"{type(report).__name__} of {output} cannot be made ({_reason(error)}); records and earlier tables stay"
        )
        print(visible(message), file=sys.stderr)
        return 1
    for name in made.outdated:
        (output / name).unlink(missing_ok=True)
    for name, content in made.files.items():
        replace_file(output / name, content)
    drawn_from = _digest(made.files, plan.commit)
    if redraw or not _is_drawn(output, drawn_from):
        (output / DRAWN).unlink(missing_ok=True)
        if _write_figures_and_page(plan, made, output):
            replace_file(output / DRAWN, drawn_from)
    write_index_above(output)
    print(visible_lines(made.text))
    there = sorted(path.name for pattern in ("*.csv", "*.png", PAGE) for path in output.glob(pattern))
    counted = [_count_line(plan, made.runs)] if len(plan.runs) else []
    damaged: Counter[Path] = Counter()
    mixed = mixed_processors(counted_processors(processors(output, damaged), plan))
    counted += [
        f"note: {shortened(note, LONGEST_NOTE)}"
        for note in [*filter(None, [mixed]), *plan.notes, *damage_notes(damaged)]
    ]
    print(visible_lines("\n" + "\n".join([*counted, f"in {output}: {', '.join(map(visible, there))}"])))
    return 0 if made.runs["status"].isin(RESULTS).all() else 1


def draw(figures: Callable[[], Mapping[str, Drawing]], output: Path) -> tuple[dict[str, bytes], bool]:
    """Write figures in parallel processes; return their contents by name, and whether all were written.

    A figure that cannot be drawn is reported in a line; all others, and the tables, are still written.
    """
    drawn: dict[str, bytes] = {}
    try:
        drawings = figures()
    except Exception as error:  # whatever a report of other people raises
        _tell_not_drawn("figures", _NotDrawn.of(error))
        return drawn, False
    entries = [(output / name, drawing) for name, drawing in drawings.items()]
    try:
        found = for_each(_written, entries, available_cores())
    except ChildProcessError:  # one that takes too much memory beside others
        remove_partial(output)
        found = for_each(_written, entries)
    for name, content in zip(drawings, found):
        if isinstance(content, _NotDrawn):
            _tell_not_drawn(name, content)
        else:
            drawn[name] = content
    return drawn, len(drawn) == len(drawings)


@dataclass(frozen=True)
class _NotDrawn:
    """Why something was not drawn, and the lines where.

    No error of other people's code is sent between processes.
    """

    reason: str
    lines: str

    @classmethod
    def of(cls, error: Exception) -> _NotDrawn:
        return cls(_reason(error), "".join(traceback.format_exception(error)))


def _written(entry: tuple[Path, Drawing]) -> bytes | _NotDrawn:
    """Write a figure and return its content; if it cannot be drawn, remove an older version."""
    path, drawing = entry
    try:
        made = drawing if isinstance(drawing, bytes) else drawing()
        content = _png(made) if isinstance(made, Chart) else made
    except Exception as error:
        path.unlink(missing_ok=True)
        return _NotDrawn.of(error)
    replace_file(path, content)
    return content


def _png(chart: Chart) -> bytes:
    from ksmea.show.charts.picture import png  # loads all of matplotlib

    return png(chart)


def _write_figures_and_page(plan: Plan, made: Made, output: Path) -> bool:
    """Write the page, its charts as pictures and further figures; return whether all were written.

    A page that cannot be made is reported in a line: the tables are already written.
    """
    try:
        page, said = None if made.page is None else made.page(), _unfinished(made.runs)
        page = page.titled(said) if page is not None and said else page
        charts: Mapping[str, Drawing] = {} if page is None else page.charts()
    except Exception as error:  # whatever a report of other people raises
        draw(made.figures, output)
        return _no_page(output, error)
    drawings, all_drawn = draw(lambda: {**charts, **_titled(made.figures(), said)}, output)
    try:
        content = experiment_page(plan, made, drawings, last_began(output), page)
    except Exception as error:
        return _no_page(output, error)
    replace_file(output / PAGE, content)
    return all_drawn


def _unfinished(runs: pd.DataFrame) -> str:
    """Number of runs that a figure shows of an unfinished experiment: '11 of 20 runs'.

    Empty for a finished one.
    """
    n_result = int(runs["status"].isin(RESULTS).sum())
    return "" if n_result == len(runs) else f"{n_result} of {len(runs)} runs"


def _titled(drawings: Mapping[str, Drawing], said: str) -> Mapping[str, Drawing]:
    """The drawings with what is said in each chart's title."""
    return {name: partial(_with_title, each, said) for name, each in drawings.items()} if said else drawings


def _with_title(drawing: Drawing, said: str) -> Any:
    made = drawing if isinstance(drawing, bytes) else drawing()
    return made.titled(said) if isinstance(made, Chart) else made


def _no_page(output: Path, error: Exception) -> bool:
    _tell_not_drawn(PAGE, _NotDrawn.of(error))
    (output / PAGE).unlink(missing_ok=True)
    return False


def _tell_not_drawn(what: str, why: _NotDrawn) -> None:
    if os.environ.get("BENCH_TRACEBACK"):
        print(why.lines, file=sys.stderr)
    print(f"{what}: cannot be drawn ({why.reason}); the tables are written", file=sys.stderr)


def _reason(error: Exception) -> str:
    return shortened(f"{type(error).__name__}: {error}", LONGEST_REASON)


def _digest(files: Mapping[str, bytes], commit: str) -> bytes:
    content = hashlib.sha256(commit.encode())
    for name in sorted(files):
        content.update(name.encode() + files[name])
    return content.hexdigest().encode()


def _is_drawn(output: Path, drawn_from: bytes) -> bool:
    """Whether the figures are there, and were drawn from this."""
    mark = output / DRAWN
    if not mark.exists() or not (output / PAGE).exists() or not any(output.glob("*.png")):
        return False
    with open_regular(mark) as file:
        return file.read() == drawn_from


def _count_line(plan: Plan, runs: pd.DataFrame) -> str:
    without = runs[~runs["status"].isin(RESULTS)]
    if without.empty:
        return (
            f"all {len(runs)} runs of {plan.name} have a result"
            if len(runs) > 1
            else f"the run of {plan.name} has a result"
        )
    unfinished = without["status"].isin(NOT_FAILED)
    reasons = Counter(
        f"{row.status}: {without_class(row.error)}" if row.error else row.status
        for row in without[~unfinished].itertuples()
    )
    shown = "; ".join(f"{count} × {shortened(reason, LONGEST_REASON)}" for reason, count in reasons.most_common(3))
    counts = without["status"].value_counts()
    parts = [f"{reasons.total()} of {len(runs)} failed ({shown})"] if reasons else []
    parts += [f"{counts[state]} of {len(runs)} {state}" for state in UNFINISHED if state in counts]
    return "; ".join(parts) + ("; the same command does the rest" if unfinished.any() and RUNNING not in counts else "")
