"""What the framework itself takes: runs that do nothing, what is done with finished ones, imports, help."""

from __future__ import annotations

from benchmarks.harness.row import PEERS, Contestant, Row

N_RUN = 100
HELP_WITHIN, IMPORT_WITHIN = 0.7, 0.4  # s of CPU
IMPORTED = {
    "ROSS": ("ross", "ross-rotordynamics"),
    "SMT": ("smt.surrogate_models", "smt"),
    "OpenTURNS": ("openturns",) * 2,
}
OWN_RECORDS = "without its page; ours makes a table and a figure"


def rows() -> list[Row]:
    runs, once_more = "benchmarks.tasks.commands:runs", "benchmarks.tasks.commands:on_results"
    return [
        *(_versus_benchopt("runs that do nothing", n, runs, {"n": n}, False) for n in (1, N_RUN)),
        _versus_benchopt("the same once more, all done", N_RUN, once_more, {"words": [], "n": N_RUN}, True),
        *(_on_results(word) for word in ("status", "collect")),
        _help(),
        _import(),
    ]


def _versus_benchopt(name: str, n: int, task: str, settings: dict[str, object], again: bool) -> Row:
    peer, asked = "benchmarks.tasks.commands:benchopt", {"n": n, "again": again}
    return Row(
        "framework",
        name,
        (Contestant("here", task, settings), Contestant("benchopt", peer, asked, "benchopt", PEERS, note=OWN_RECORDS)),
        unit="command",
        size=n,
        size_of="runs",
        budget=60.0,
    )


def _on_results(word: str) -> Row:
    return Row(
        "framework",
        word,
        (Contestant("here", "benchmarks.tasks.commands:on_results", {"words": [word], "n": N_RUN}),),
        unit="command",
        size=N_RUN,
        size_of="runs",
        budget=15.0,
    )


def _help() -> Row:
    return Row(
        "framework",
        "python -m bench help",
        (
            Contestant("here", "benchmarks.tasks.commands:bench", {"words": ["help"]}),
            _starting("numpy alone", "numpy", "numpy"),
        ),
        no_more_than=HELP_WITHIN,
        is_quick=True,
        budget=10.0,
    )


def _import() -> Row:
    return Row(
        "framework",
        "import",
        (
            _starting("ksmea", "ksmea", "ksmea-bench"),
            _starting("numpy alone", "numpy", "numpy"),
            *(_starting(name, module, library, PEERS) for name, (module, library) in IMPORTED.items()),
        ),
        no_more_than=IMPORT_WITHIN,
        is_quick=True,
        budget=40.0,
    )


def _starting(name: str, module: str, library: str, environment: str = "here") -> Contestant:
    return Contestant(name, "benchmarks.tasks.commands:importing", {"module": module}, library, environment)
