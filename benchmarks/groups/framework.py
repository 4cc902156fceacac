"""Cost of the framework itself: empty runs, work on finished ones, imports and help.

Table 3 of the paper is a whole command, 80 runs on one worker and on two.

That is wall time, since it is about cores: on a machine that does other things too its ratio says nothing.
"""

from __future__ import annotations

from functools import partial

from benchmarks.harness.row import NUMPY, OWN, WALL, Contestant, Row, by

N_RUN = 100
HELP_WITHIN, IMPORT_WITHIN = 0.7, 0.4  # s of CPU
TABLE3_WITHIN, TABLE3_SPEED_UP = 60.0, 1.7  # s, on two idle cores
IMPORTED = {
    "ROSS": ("ross", "ross-rotordynamics"),
    "SMT": ("smt.surrogate_models", "smt"),
    "OpenTURNS": ("openturns",) * 2,
}
OWN_RECORDS = "without its page; ours makes a table and a figure"
_row = partial(Row, "framework")
_of_runs = partial(_row, unit="command", size_of="runs")


def rows() -> list[Row]:
    runs = [by("here", "commands:runs", n=n) for n in (1, N_RUN)]
    once_more = by("here", "commands:on_results", words=[], n=N_RUN)
    return [
        *(_versus_benchopt("runs that do nothing", here, n) for here, n in zip(runs, (1, N_RUN), strict=True)),
        _versus_benchopt("the same once more, all done", once_more, N_RUN, again=True),
        *(_on_results(word) for word in ("status", "collect")),
        _help(),
        _import(),
    ]


def table3_rows() -> list[Row]:
    two = by("2 workers", "commands:table3", workers=2)
    one = by("1 worker", "commands:table3", at_least=TABLE3_SPEED_UP, note="wants two idle cores", workers=1)
    once = {"is_warmed": False, "turns": 1, "budget": 600.0, "limit": 1200.0}
    name = "80 runs, the whole command"
    return [Row("table3", name, (two, one), clock=WALL, no_more_than=TABLE3_WITHIN, **once)]


def _versus_benchopt(name: str, here: Contestant, n: int, again: bool = False) -> Row:
    benchopt = by("benchopt", "commands:benchopt", "benchopt", note=OWN_RECORDS, n=n, again=again)
    return _of_runs(name, (here, benchopt), size=n, budget=60.0)


def _on_results(word: str) -> Row:
    return _of_runs(word, (by("here", "commands:on_results", words=[word], n=N_RUN),), size=N_RUN, budget=15.0)


def _help() -> Row:
    contestants = by("here", "commands:bench", words=["help"]), _importing("numpy alone", NUMPY, NUMPY)
    return _row("python -m bench help", contestants, no_more_than=HELP_WITHIN, is_quick=True, budget=10.0)


def _import() -> Row:
    contestants = (
        _importing("ksmea", "ksmea", OWN),
        _importing("numpy alone", NUMPY, NUMPY),
        *(_importing(name, *module_and_library) for name, module_and_library in IMPORTED.items()),
    )
    return _row("import", contestants, no_more_than=IMPORT_WITHIN, is_quick=True, budget=40.0)


def _importing(name: str, module: str, library: str) -> Contestant:
    return by(name, "commands:importing", library, module=module)
