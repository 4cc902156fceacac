"""Diagnosis with all effects, by its parts.

Its data are explained by the model, lack one effect, or are far off.

No other program does one. Beside it stands what a thousand evaluations by numpy's solver take, so that the figure does not depend
on the machine. What a second core gains is about wall time, and wants two idle ones.
"""

from __future__ import annotations

from functools import partial

from benchmarks.harness.row import NUMPY, WALL, Row, by

DATA = {
    "adequate": "data of an adequate model",
    "runout": "data that hide a runout",
    "speed_dependent_stiffness": "data that hide a stiffness that grows with speed",
    "flexible_pedestal": "data that hide a flexible pedestal",
    "mass": "data that hide one effect",
    "far off": "data that hide three effects",
}
_row = partial(Row, "diagnosis", unit="diagnosis", is_warmed=False, turns=3)


def rows() -> list[Row]:
    return [*map(_diagnosis, DATA), *map(_shared, ("mass", "far off"))]


def _diagnosis(data: str) -> Row:
    here = by("here", "diagnose_here:diagnosis", data=data)
    solver = by(
        "1000 evaluations by numpy.linalg.solve", "fe_dense:evaluations", NUMPY, n_speed=53, batch=100, unit=1000
    )
    return _row(DATA[data], (here, solver), budget=300.0)


def _shared(data: str) -> Row:
    two = by("2 workers", "diagnose_here:shared", data=data, workers=2)
    one = by("1 worker", "diagnose_here:shared", note="wants two idle cores", data=data, workers=1)
    return _row(f"{DATA[data]}, wall time", (two, one), clock=WALL, budget=600.0)
