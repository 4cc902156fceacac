"""Evaluations of the finite-element model of the three-disk rotor, its derivatives and its critical speeds."""

from __future__ import annotations

from benchmarks.harness.row import PEERS, Contestant, Row

SPEEDS = (53, 131)
ROSS, NUMPY = "ross-rotordynamics", "numpy"
SAME = "the same elements"


def rows() -> list[Row]:
    return [
        *(_evaluation(n_speed, batch) for n_speed in SPEEDS for batch in (1, 100)),
        _set_up(),
        *(_sensitivity(effect) for effect in ("", "flexible_pedestal", "mass")),
        *(_reduction(mesh) for mesh in (13, 26, 52, 104)),
        _critical_speeds(),
    ]


def _evaluation(n_speed: int, batch: int) -> Row:
    at_once, name = {"n_speed": n_speed, "batch": batch}, "one evaluation" if batch == 1 else f"batch of {batch}"
    first = n_speed == SPEEDS[0]
    ross = (
        Contestant(
            "ROSS: rebuild, run_unbalance_response",
            "benchmarks.tasks.fe_ross:evaluation",
            {"n_speed": n_speed},
            ROSS,
            PEERS,
            at_least=10_000 if first and batch > 1 else None,
            note=SAME,
        ),
        Contestant(
            "ROSS: rebuild, loop over transfer_matrix",
            "benchmarks.tasks.fe_ross:evaluation",
            {"n_speed": n_speed, "loop": True},
            ROSS,
            PEERS,
            note=SAME,
        ),
    )
    return Row(
        "fe",
        name,
        (
            Contestant("here", "benchmarks.tasks.fe_here:evaluations", at_once),
            Contestant(
                "numpy.linalg.solve",
                "benchmarks.tasks.fe_dense:evaluations",
                at_once,
                NUMPY,
                at_least={1: 25, 100: 150}[batch] if first else None,
                note=SAME,
            ),
            *ross,
        ),
        unit="evaluation",
        size=n_speed,
        size_of="speeds",
        is_quick=first,
    )


def _set_up() -> Row:
    n_speed = {"n_speed": SPEEDS[0]}
    return Row(
        "fe",
        "a problem from nothing, one evaluation",
        (
            Contestant("here", "benchmarks.tasks.fe_here:set_up", n_speed),
            Contestant("numpy.linalg.solve", "benchmarks.tasks.fe_dense:set_up", n_speed, NUMPY, note=SAME),
            Contestant("ROSS", "benchmarks.tasks.fe_ross:set_up", n_speed, ROSS, PEERS, note=SAME),
        ),
        size=SPEEDS[0],
        size_of="speeds",
    )


def _sensitivity(effect: str) -> Row:
    which = {"effect": effect}
    return Row(
        "fe",
        f"sensitivities, {effect.replace('_', ' ')}" if effect else "sensitivities of 5 unknowns",
        (
            Contestant("here", "benchmarks.tasks.fe_here:sensitivity", which),
            Contestant("central differences of ours, one batch", "benchmarks.tasks.fe_here:differences", which),
        ),
        unit="Jacobian",
        size=SPEEDS[0],
        size_of="speeds",
        is_quick=effect == "mass",
    )


def _reduction(mesh: int) -> Row:
    tasks = "benchmarks.tasks.fe_here"
    return Row(
        "fe",
        "reduction to the ports",
        (
            Contestant("here, banded", f"{tasks}:reduction", {"mesh": mesh}),
            Contestant("dense elimination", f"{tasks}:dense_reduction", {"mesh": mesh}),
        ),
        size=mesh,
        size_of="elements",
        budget=10.0,
    )


def _critical_speeds() -> Row:
    return Row(
        "fe",
        "critical speeds below 1500 rad/s",
        (
            Contestant("here", "benchmarks.tasks.fe_here:critical_speeds"),
            Contestant(
                "ROSS: run_critical_speed",
                "benchmarks.tasks.fe_ross:critical_speeds",
                {},
                ROSS,
                PEERS,
                note="to 0.5 % by its default, six of them; ours to 1e-11, four",
            ),
        ),
        budget=40.0,
    )
