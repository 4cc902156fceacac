"""Evaluations of the finite-element model of the three-disk rotor.

Its derivatives and critical speeds are included.
"""

from __future__ import annotations

from functools import partial

from benchmarks.harness.row import NUMPY, ROSS, Row, by

SPEEDS = (53, 131)
SAME = "the same elements"
_row = partial(Row, "fe")
_of_speeds = partial(_row, size_of="speeds")


def rows() -> list[Row]:
    return [
        *(_evaluation(n_speed, batch) for n_speed in SPEEDS for batch in (1, 100)),
        _set_up(SPEEDS[0]),
        *(_sensitivity(effect) for effect in ("", "flexible_pedestal", "mass")),
        *(_reduction(mesh) for mesh in (13, 26, 52, 104)),
        _critical_speeds(),
    ]


def _evaluation(n_speed: int, batch: int) -> Row:
    is_first = n_speed == SPEEDS[0]
    solver_demand = {1: 25, 100: 150}[batch] if is_first else None
    ross_demand = 10_000 if is_first and batch > 1 else None
    ross = partial(by, task="fe_ross:evaluation", library=ROSS, note=SAME, n_speed=n_speed)
    ports_demand = {1: 1, 100: 4}[batch] if is_first else None
    contestants = (
        by("here", "fe_here:evaluations", n_speed=n_speed, batch=batch),
        by("numpy: 4 × 4 ports", "fe_ports:evaluations", NUMPY, ports_demand, SAME, n_speed=n_speed, batch=batch),
        by("numpy.linalg.solve", "fe_dense:evaluations", NUMPY, solver_demand, SAME, n_speed=n_speed, batch=batch),
        ross("ROSS: rebuild, run_unbalance_response", at_least=ross_demand),
        ross("ROSS: rebuild, loop over transfer_matrix", loop=True),
    )
    name = "one evaluation" if batch == 1 else f"batch of {batch}"
    demand = {1: 25e-6, 100: 3e-6}[batch] if is_first else None
    return _of_speeds(name, contestants, unit="evaluation", size=n_speed, is_quick=is_first, no_more_than=demand)


def _set_up(n_speed: int) -> Row:
    here = by("here", "fe_here:set_up", n_speed=n_speed)
    solver = by("numpy.linalg.solve", "fe_dense:set_up", NUMPY, note=SAME, n_speed=n_speed)
    ross = by("ROSS", "fe_ross:set_up", ROSS, note=SAME, n_speed=n_speed)
    return _of_speeds("a problem from nothing, one evaluation", (here, solver, ross), size=n_speed)


def _sensitivity(effect: str) -> Row:
    here = by("here", "fe_here:sensitivity", effect=effect)
    differences = by("central differences of ours, one batch", "fe_here:differences", effect=effect)
    name = f"sensitivities, {effect.replace('_', ' ')}" if effect else "sensitivities of 5 unknowns"
    return _of_speeds(name, (here, differences), unit="Jacobian", size=SPEEDS[0], is_quick=effect == "mass")


def _reduction(mesh: int) -> Row:
    banded = by("here, banded", "fe_here:reduction", mesh=mesh)
    dense = by("dense elimination", "fe_here:dense_reduction", mesh=mesh)
    return _row("reduction to the ports", (banded, dense), size=mesh, size_of="elements", budget=10.0)


def _critical_speeds() -> Row:
    here = by("here", "fe_here:critical_speeds")
    accuracy = "to 0.5 % by its default, six of them; ours to 1e-11, four"
    ross = by("ROSS: run_critical_speed", "fe_ross:critical_speeds", ROSS, note=accuracy)
    return _row("critical speeds below 1500 rad/s", (here, ross), budget=40.0)
