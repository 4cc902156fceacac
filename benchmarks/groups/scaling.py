"""How cost grows: with elements, speeds, points at once, samples, outputs and effects. Exponents are those of power laws over each
series. Workers are in the group table3, runs in docs/scale.md."""

from __future__ import annotations

from typing import Any, NamedTuple

from benchmarks.groups import handed
from benchmarks.harness.row import Contestant, Row


class Series(NamedTuple):
    """A row at several sizes: `size_of` is what is counted, `setting` the name that the task has for it."""

    name: str
    unit: str
    size_of: str
    setting: str
    sizes: tuple[int, ...]
    task: str
    settings: dict[str, Any]


SET_UP, EVALUATIONS = "benchmarks.tasks.fe_here:set_up", "benchmarks.tasks.fe_here:evaluations"
DIAGNOSIS, FIT = "benchmarks.tasks.diagnose_here:of_effects", "benchmarks.tasks.kriging_here:fit_all"
IN_BATCH, ELEMENTS = "evaluation in a batch of 100", (13, 26, 52, 104)
SAMPLES, OUTPUTS = (50, 100, 200, 400), (1, 26, 53, 106)


def rows() -> list[Row]:
    series = [
        Series("set-up and one evaluation", "call", "elements", "mesh", ELEMENTS, SET_UP, {"n_speed": 53}),
        Series(IN_BATCH, "evaluation", "elements", "mesh", ELEMENTS, EVALUATIONS, {"n_speed": 53, "batch": 100}),
        Series(IN_BATCH, "evaluation", "speeds", "n_speed", (53, 106, 212, 424), EVALUATIONS, {"batch": 100}),
        Series("evaluation", "evaluation", "points", "batch", (1, 10, 100, 1000), EVALUATIONS, {"n_speed": 53}),
        Series("diagnosis without location", "diagnosis", "effects", "n_effect", (2, 4, 8), DIAGNOSIS, {}),
        Series("Kriging fit", "fit", "outputs", "outputs", OUTPUTS, FIT, {"samples": handed.samples(100)}),
    ]
    of_samples = [
        _row(Series("Kriging fit", "fit", "samples", "", (n,), FIT, {"samples": handed.samples(n)}), n) for n in SAMPLES
    ]
    return [*(_row(each, size) for each in series for size in each.sizes), *of_samples]


def _row(series: Series, size: int) -> Row:
    settings = {**series.settings, series.setting: size} if series.setting else series.settings
    only = (Contestant("here", series.task, settings),)
    return Row("scaling", series.name, only, unit=series.unit, size=size, size_of=series.size_of, budget=8.0)
