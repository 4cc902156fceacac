"""A diagnosis with all effects, by its parts, on data that the model explains, that lack one effect, and that are far off.

No other program does one. Beside it stands what a thousand evaluations by numpy's solver take, so that the figure does not depend
on the machine. What a second core gains is about wall time, and wants two idle ones.
"""

from __future__ import annotations

from benchmarks.harness.row import WALL, Contestant, Row

DATA = {"adequate": "an adequate model", "mass": "one effect", "far off": "three effects"}


def rows() -> list[Row]:
    return [*(_diagnosis(data, words) for data, words in DATA.items()), *map(_shared, ("mass", "far off"))]


def _diagnosis(data: str, words: str) -> Row:
    return Row(
        "diagnosis",
        f"data of {words}" if data == "adequate" else f"data that hide {words}",
        (
            Contestant("here", "benchmarks.tasks.diagnose_here:diagnosis", {"data": data}),
            Contestant(
                "1000 evaluations by numpy.linalg.solve",
                "benchmarks.tasks.fe_dense:evaluations",
                {"n_speed": 53, "batch": 100, "unit": 1000},
                "numpy",
            ),
        ),
        unit="diagnosis",
        is_warmed=False,
        turns=3,
        budget=300.0,
    )


def _shared(data: str) -> Row:
    task = "benchmarks.tasks.diagnose_here:shared"
    return Row(
        "diagnosis",
        f"data that hide {DATA[data]}, wall time",
        (
            Contestant("2 workers", task, {"data": data, "workers": 2}),
            Contestant("1 worker", task, {"data": data, "workers": 1}, note="wants two idle cores"),
        ),
        unit="diagnosis",
        clock=WALL,
        is_warmed=False,
        turns=3,
        budget=600.0,
    )
