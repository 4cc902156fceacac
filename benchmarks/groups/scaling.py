"""How cost grows: with elements, speeds, points at once, samples, outputs and effects. Exponents are those of power laws over each
series. Workers are in the group table3, runs in docs/scale.md."""

from __future__ import annotations

from benchmarks.groups import handed
from benchmarks.harness.row import Contestant, Row

FE = "benchmarks.tasks.fe_here:"
SERIES = {
    "set-up and one evaluation": ("elements", "mesh", (13, 26, 52, 104), f"{FE}set_up", {"n_speed": 53}),
    "one evaluation of 100, elements": (
        "elements",
        "mesh",
        (13, 26, 52, 104),
        f"{FE}evaluations",
        {"n_speed": 53, "batch": 100},
    ),
    "one evaluation of 100, speeds": ("speeds", "n_speed", (53, 106, 212, 424), f"{FE}evaluations", {"batch": 100}),
    "one evaluation, points at once": ("points", "batch", (1, 10, 100, 1000), f"{FE}evaluations", {"n_speed": 53}),
    "diagnosis without location": ("effects", "n_effect", (2, 4, 8), "benchmarks.tasks.diagnose_here:of_effects", {}),
}
SAMPLES, OUTPUTS = (50, 100, 200, 400), (1, 26, 53, 106)


def rows() -> list[Row]:
    fixed = [
        _row(name, size, size_of, task, {**settings, field: size})
        for name, (size_of, field, sizes, task, settings) in SERIES.items()
        for size in sizes
    ]
    fit = "benchmarks.tasks.kriging_here:fit_all"
    of_samples = [
        _row("Kriging fit of 106 outputs", n, "samples", fit, {"samples": handed.samples(n)}) for n in SAMPLES
    ]
    of_outputs = [
        _row("Kriging fit of 100 samples", q, "outputs", fit, {"samples": handed.samples(100), "outputs": q})
        for q in OUTPUTS
    ]
    return [*fixed, *of_samples, *of_outputs]


def _row(name: str, size: int, size_of: str, task: str, settings: dict[str, object]) -> Row:
    return Row("scaling", name, (Contestant("here", task, settings),), size=size, size_of=size_of, budget=8.0)
