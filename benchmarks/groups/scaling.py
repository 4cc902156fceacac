"""Growth of cost with elements, speeds, points at once, samples, outputs and effects.

Exponents are those of power laws over each series. Workers are in the group table3, runs in docs/cluster.md.
"""

from __future__ import annotations

from typing import Any

from benchmarks.harness.row import Row, by
from benchmarks.tasks import data

ELEMENTS = (13, 26, 52, 104)
EVALUATIONS, FIT, LOCATION = "fe_here:evaluations", "kriging:fit_all", "diagnose_here:location"
IN_BATCH = "evaluation in a batch of 100"


def rows() -> list[Row]:
    samples = {"samples": data.samples(100)}
    return [
        *_series("set-up and one evaluation", "call", "elements", "mesh", ELEMENTS, "fe_here:set_up", n_speed=53),
        *_series(IN_BATCH, "evaluation", "elements", "mesh", ELEMENTS, EVALUATIONS, n_speed=53, batch=100),
        *_series(IN_BATCH, "evaluation", "speeds", "n_speed", (53, 106, 212, 424), EVALUATIONS, batch=100),
        *_series("evaluation", "evaluation", "points", "batch", (1, 10, 100, 1000), EVALUATIONS, n_speed=53),
        *_series(
            "diagnosis without location", "diagnosis", "effects", "n_effect", (2, 4, 8), "diagnose_here:of_effects"
        ),
        *_series("location", "location", "elements", "mesh", (7, 13, 26), LOCATION, n_speed=66),
        *_series("location", "location", "speeds", "n_speed", (33, 66, 132), LOCATION, mesh=13),
        *_series("Kriging fit", "fit", "outputs", "outputs", (1, 26, 53, 106), FIT, **samples),
        *(_row("Kriging fit", "fit", n, "samples", FIT, samples=data.samples(n)) for n in (50, 100, 200, 400)),
    ]


def _series(
    name: str, unit: str, size_of: str, setting: str, sizes: tuple[int, ...], task: str, **settings: Any
) -> list[Row]:
    """A row at several sizes: `size_of` is what is counted, `setting` the name that the task has for it."""
    return [_row(name, unit, size, size_of, task, **settings, **{setting: size}) for size in sizes]


def _row(name: str, unit: str, size: int, size_of: str, task: str, **settings: Any) -> Row:
    return Row("scaling", name, (by("here", task, **settings),), unit=unit, size=size, size_of=size_of, budget=8.0)
