"""Kriging of 106 outputs at once and of one of them.

Fit, prediction and one more sample, beside four other libraries.

The models are alike but not the same: each estimates one anisotropic Gaussian correlation by its own objective, scikit-learn about a
constant mean, the others about a linear trend. So the held-out error stands in the row, and predictions differ by what the
models do. Fits are of another design in each turn; one that predicts hardly better than a mean counts as failed.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from benchmarks.harness.row import Contestant, Row, by
from benchmarks.tasks import data

SIZES = (40, 70, 100, 200)
LARGEST, QUICK = SIZES[-1], 100
FEW, MANY = 100, 10_000  # points predicted
LIBRARIES = {"scikit-learn": "scikit-learn", "pydacefit": "pydacefit", "SMT": "smt", "OpenTURNS": "openturns"}
ALL_AT_ONCE = ("scikit-learn", "pydacefit")
FIT_DEMANDS = {("scikit-learn", 106): 15.0, ("SMT", 1): 100.0}  # at the largest size
PREDICT_DEMANDS = {("scikit-learn", 106): 1.0}  # of many points there
_row = partial(Row, "surrogate", size_of="samples")


def rows() -> list[Row]:
    return [
        *(row for n in SIZES for row in (_fit(n, 106), _predict(n, FEW, 106), _predict(n, MANY, 106), _append(n))),
        *(row for n in (QUICK, LARGEST) for row in (_fit(n, 1), _predict(n, MANY, 1))),
    ]


def _fit(n: int, q: int) -> Row:
    samples = data.samples(n, q)
    contestants = (
        by("here", "kriging:fit", model="ours", samples=samples),
        *_peers(q, "kriging:fit", FIT_DEMANDS if n == LARGEST else {}, samples=samples),
        by("here, likelihood", "kriging:fit", model="ours by likelihood", samples=samples),
    )
    quality = {
        "quality": "RMSE of ln amplitude, held out",
        "failed_above": data.read_samples(samples).failed_above,
    }
    settings = {"unit": "output", "is_quick": n == QUICK and q > 1, "budget": 40.0, "least_turns": data.N_DESIGN}
    return _row(f"Kriging fit, {_outputs(q)}", contestants, size=n, **quality, **settings)


def _predict(n: int, points: int, q: int) -> Row:
    settings = {"samples": data.samples(n, q), "points": points}
    demands = PREDICT_DEMANDS if (n, points) == (LARGEST, MANY) else {}
    ours = by("here", "kriging:predict", model="ours", **settings)
    contestants = (ours, *_peers(q, "kriging:predict", demands, **settings))
    name = f"Kriging prediction of {points} points, {_outputs(q)}"
    return _row(name, contestants, size=n, unit="value", is_quick=n == QUICK and q > 1, budget=15.0)


def _append(n: int) -> Row:
    ours = by("here", "kriging:append", samples=data.samples(n))
    refit = by("scikit-learn: fit without optimiser", "kriging:refit", "scikit-learn", samples=data.samples(n))
    return _row("one more sample, θ kept", (ours, refit), size=n, budget=10.0)


def _outputs(q: int) -> str:
    return "one output" if q == 1 else f"{q} outputs"


def _peers(q: int, task: str, demands: dict[tuple[str, int], float], **settings: Any) -> list[Contestant]:
    """Peers that fit so many outputs."""
    return [
        by(name, task, library, demands.get((name, q)), model=name, **settings)
        for name, library in LIBRARIES.items()
        if q == 1 or name in ALL_AT_ONCE
    ]
