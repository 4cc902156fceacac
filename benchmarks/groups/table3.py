"""The main job, Table 3 of the paper, as a whole command: 80 runs on one worker and on two.

Wall time, since it is about cores: on a machine that does other things too its ratio says nothing.
"""

from __future__ import annotations

from benchmarks.harness.row import WALL, Contestant, Row

WITHIN = 60.0  # s, on two idle cores
SPEED_UP = 1.7


def rows() -> list[Row]:
    task = "benchmarks.tasks.commands:table3"
    return [
        Row(
            "table3",
            "80 runs, the whole command",
            (
                Contestant("2 workers", task, {"workers": 2}),
                Contestant("1 worker", task, {"workers": 1}, at_least=SPEED_UP, note="wants two idle cores"),
            ),
            clock=WALL,
            is_warmed=False,
            turns=1,
            budget=600.0,
            limit=1200.0,
            no_more_than=WITHIN,
        )
    ]
