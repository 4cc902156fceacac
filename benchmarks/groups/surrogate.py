"""Kriging of 106 outputs at once and of one of them: fit, prediction and one more sample, beside four other libraries.

The models are alike but not the same: each estimates one anisotropic Gaussian correlation by its own objective, scikit-learn about a
constant mean, the others about a linear trend. So the held-out error stands in the row, and predictions differ by what the
models do.
"""

from __future__ import annotations

from benchmarks.groups import handed
from benchmarks.harness.row import HERE, PEERS, Contestant, Row

SIZES = (40, 70, 100, 200)
LARGEST, QUICK = SIZES[-1], 100
FEW, MANY = 100, 10_000  # points predicted
LIBRARIES = {  # module of the tasks: how it is called, its distribution, where it runs
    "kriging_sklearn": ("scikit-learn", "scikit-learn", HERE),
    "kriging_pydacefit": ("pydacefit", "pydacefit", PEERS),
    "kriging_smt": ("SMT", "smt", PEERS),
    "kriging_openturns": ("OpenTURNS", "openturns", PEERS),
}
ALL_AT_ONCE = ("kriging_sklearn", "kriging_pydacefit")
FIT_DEMANDS = {("kriging_sklearn", 106): 15.0, ("kriging_smt", 1): 100.0}  # at the largest size
PREDICT_DEMANDS = {("kriging_sklearn", 106): 1.0}  # of many points there


def rows() -> list[Row]:
    return [
        *(row for n in SIZES for row in (_fit(n, 106), _predict(n, FEW, 106), _predict(n, MANY, 106), _append(n))),
        *(row for n in (QUICK, LARGEST) for row in (_fit(n, 1), _predict(n, MANY, 1))),
    ]


def _fit(n: int, q: int) -> Row:
    samples = {"samples": handed.samples(n, q)}
    ours = "benchmarks.tasks.kriging_here:fit"
    return Row(
        "surrogate",
        f"Kriging fit, {_outputs(q)}",
        (
            Contestant("here", ours, samples),
            *_peers(q, "fit", samples, FIT_DEMANDS if n == LARGEST else {}),
            Contestant("here, likelihood", ours, {**samples, "objective": "likelihood"}),
        ),
        unit="output",
        size=n,
        size_of="samples",
        quality="RMSE of ln amplitude, held out",
        is_quick=n == QUICK and q > 1,
        budget=40.0,
    )


def _predict(n: int, points: int, q: int) -> Row:
    settings = {"samples": handed.samples(n, q), "points": points}
    demands = PREDICT_DEMANDS if (n, points) == (LARGEST, MANY) else {}
    return Row(
        "surrogate",
        f"Kriging prediction of {points} points, {_outputs(q)}",
        (
            Contestant("here", "benchmarks.tasks.kriging_here:predict", settings),
            *_peers(q, "predict", settings, demands),
        ),
        unit="value",
        size=n,
        size_of="samples",
        is_quick=n == QUICK and q > 1,
        budget=15.0,
    )


def _append(n: int) -> Row:
    samples = {"samples": handed.samples(n)}
    refit = "benchmarks.tasks.kriging_sklearn:append"
    return Row(
        "surrogate",
        "one more sample, θ kept",
        (
            Contestant("here", "benchmarks.tasks.kriging_here:append", samples),
            Contestant("scikit-learn: fit without optimiser", refit, samples, "scikit-learn"),
        ),
        size=n,
        size_of="samples",
        budget=10.0,
    )


def _outputs(q: int) -> str:
    return "one output" if q == 1 else f"{q} outputs"


def _peers(q: int, task: str, settings: dict[str, object], demands: dict[tuple[str, int], float]) -> list[Contestant]:
    """Those that fit so many outputs."""
    return [
        Contestant(name, f"benchmarks.tasks.{module}:{task}", settings, library, environment, demands.get((module, q)))
        for module, (name, library, environment) in LIBRARIES.items()
        if q == 1 or module in ALL_AT_ONCE
    ]
