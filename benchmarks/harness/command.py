"""The command `python -m benchmarks`."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from bench.storage.own_files import REFERENCE
from benchmarks.groups import diagnosis, fe, framework, identification, scaling, surrogate
from benchmarks.harness.figure import ratio_chart
from benchmarks.harness.machine import this_machine
from benchmarks.harness.measure import measured
from benchmarks.harness.processes import started
from benchmarks.harness.report import number, page, text, title_of
from benchmarks.harness.row import Row
from benchmarks.harness.setup import VARIABLE, peers_folder, setup
from benchmarks.harness.table import Line, fallen, lines_of, merged, read, same_ratios, table, write
from ksmea.errors import SettingError, unknown
from ksmea.show.charts.picture import png

GROUPS: dict[str, Callable[[], list[Row]]] = {
    "fe": fe.rows,
    "surrogate": surrogate.rows,
    "optimizers": identification.optimizer_rows,
    "identification": identification.rows,
    "diagnosis": diagnosis.rows,
    "framework": framework.rows,
    "scaling": scaling.rows,
    "table3": framework.table3_rows,
}
CHECK, SETUP = "check", "setup"
COMMITTED = REFERENCE / "benchmarks.csv"
BAD_INPUT, INTERRUPTED = 2, 130
QUICK_TURNS, QUICK_BUDGET = 5, 3.0  # of a row, s
USAGE = f"""\
usage: python -m benchmarks [GROUP …] [--repetitions N] [--out DIR] [--only TEXT] [--peers DIR]
       python -m benchmarks check [GROUP …] [--quick]    ratios now beside the committed ones; exit 0 either way
       python -m benchmarks setup [DIR]                  an environment with the other libraries

groups: {" ".join(GROUPS)} (all if none is named)

--repetitions N  turns of each row, fewer where they take long (11)
--out DIR        benchmarks.csv, .png and .html go there (results/benchmarks); rows of a table that is there are replaced, others kept
--only TEXT      only rows whose title has it, such as --only "batch of 100"
--peers DIR      the environment of the other libraries (.peers, or {VARIABLE}); their lines are skipped without it
"""


def main(words: Sequence[str]) -> int:
    """Run the command and return its exit code.

    0: measured; 2: bad input, stated in one line; 130: interrupted, with the measured rows written.
    """
    if any(word in ("-h", "--help", "help") for word in words):
        print(USAGE, end="")
        return 0
    try:
        return _entered(words)
    except SettingError as error:
        print(error, file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED


def _entered(words: Sequence[str]) -> int:
    asked = _parsed(words)
    if asked.words[:1] == [SETUP]:
        return setup(Path(asked.words[1]) if asked.words[1:] else peers_folder())
    checks = asked.words[:1] == [CHECK]
    groups = asked.words[checks:]
    for group in groups:
        if group not in GROUPS:
            raise unknown("group", group, list(GROUPS))
    rows = [row for group in groups or GROUPS for row in GROUPS[group]() if asked.only in row.title]
    if not rows:
        raise SettingError(
            f"--only: expected a part of a row's title, none has {asked.only!r}; leave it out to see all titles"
        )
    if checks:
        return check([row for row in rows if row.is_quick or not asked.quick], asked)
    return run(rows, asked)


def run(rows: Sequence[Row], asked: argparse.Namespace) -> int:
    """Measure the rows.

    The table is written after each of them, so that nothing is lost, picture and page at the end.
    """
    lines: list[Line] = []
    path = asked.out / "benchmarks.csv"
    before = read(path) if path.is_file() else None
    try:
        for row_lines in each_measured(rows, asked.peers, asked.repetitions):
            lines += row_lines
            write(table(lines) if before is None else merged(before, table(lines)), path)
            print(text(table(row_lines)), flush=True)
    finally:
        if lines:
            draw(path)
            print(f"\n{path}, .png and .html")
    return 0


def check(rows: Sequence[Row], asked: argparse.Namespace) -> int:
    """Measure shortly, and say which ratios have fallen by more than a third against the committed ones."""
    committed = read(asked.against)
    turns = min(asked.repetitions, QUICK_TURNS) if asked.quick else asked.repetitions
    short = [dataclasses.replace(row, budget=QUICK_BUDGET) for row in rows] if asked.quick else rows
    both = same_ratios(table([line for each in each_measured(short, asked.peers, turns) for line in each]), committed)
    slower = fallen(both)
    for _, line in slower.iterrows():
        ratios = f"{number(line['ratio_now'])} × here, {number(line['ratio'])} × committed"
        print(f"slower: {title_of(line)}, {line['contestant']}: {ratios}")
    print(f"{len(both)} ratios compared with {asked.against.name}: {len(slower)} fell by more than a third")
    return 0


def each_measured(rows: Sequence[Row], peers: Path, turns: int) -> Iterable[list[Line]]:
    """The lines of each row, as soon as it is measured; processes are kept within a group."""
    machine = this_machine()
    for group in dict.fromkeys(row.group for row in rows):
        with started(peers) as processes:
            for row in rows:
                if row.group == group:
                    yield lines_of(row, measured(row, processes, turns), machine)


def draw(path: Path) -> None:
    """Picture and page of a table, as it is read back: they cannot part from it."""
    whole = read(path)
    picture = png(ratio_chart(whole))
    path.with_suffix(".png").write_bytes(picture)
    path.with_suffix(".html").write_bytes(page(whole, picture))


def _parsed(words: Sequence[str]) -> argparse.Namespace:
    parser = _Parser(add_help=False)
    parser.add_argument("words", nargs="*")
    parser.add_argument("--repetitions", type=_count, default=11)
    parser.add_argument("--out", type=Path, default=Path("results/benchmarks"))
    parser.add_argument("--peers", type=Path, default=peers_folder())
    parser.add_argument("--against", type=Path, default=COMMITTED)
    parser.add_argument("--only", default="")
    parser.add_argument("--quick", action="store_true")
    return parser.parse_intermixed_args(list(words))


def _count(word: str) -> int:
    if not word.isdecimal() or int(word) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got {word}")
    return int(word)


class _Parser(argparse.ArgumentParser):
    """One line for bad input, as everywhere here."""

    def error(self, message: str) -> None:  # type: ignore[override]
        raise SettingError(f"benchmarks: {message}; python -m benchmarks --help says what there is")
