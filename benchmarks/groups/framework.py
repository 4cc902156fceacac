"""What the framework itself takes: runs that do nothing, what is done with finished ones, imports, help."""

from __future__ import annotations

from benchmarks.harness.row import PEERS, Contestant, Row

N_RUN = 100
HELP_WITHIN, IMPORT_WITHIN = 0.7, 0.4  # s of CPU
IMPORTED = {"ROSS": ("ross", "ross-rotordynamics"), "SMT": ("smt.surrogate_models", "smt"), "OpenTURNS": ("openturns",) * 2}
OWN_RECORDS = "benchopt's runs give a number, ours a record with intervals"


def rows() -> list[Row]:
    return [
        _versus_benchopt(f"{N_RUN} runs that do nothing", "benchmarks.tasks.commands:runs", {"n": N_RUN}, False),
        _versus_benchopt(
            f"the same {N_RUN} once more, all done", "benchmarks.tasks.commands:on_results", {"words": [], "n": N_RUN}, True
        ),
        *(_on_results(word) for word in ("status", "collect")),
        _help(),
        _import(),
    ]


def _versus_benchopt(name: str, task: str, settings: dict[str, object], again: bool) -> Row:
    peer = "benchmarks.tasks.commands:benchopt"
    return Row(
        "framework",
        name,
        (
            Contestant("here", task, settings),
            Contestant("benchopt", peer, {"again": again}, "benchopt", PEERS, note=OWN_RECORDS),
        ),
        unit="run",
        budget=60.0,
    )


def _on_results(word: str) -> Row:
    return Row(
        "framework",
        f"{word} of {N_RUN} runs",
        (Contestant("here", "benchmarks.tasks.commands:on_results", {"words": [word], "n": N_RUN}),),
        unit="run",
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
