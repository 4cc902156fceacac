"""The disks of a machine, where weights are fixed, as a problem names them among its landmarks."""

from __future__ import annotations

from ksmea.contracts import Problem

ON_DISK = 1e-3  # m, from the middle of a disk: a weight that is nearer sits on it


def disk_positions(problem: Problem) -> dict[str, float]:
    """Where each disk is, m, by its name; empty where the problem knows of none."""
    return {name: position for name, position in problem.landmarks.items() if name.startswith("disk")}


def is_on(position: float, disk: float) -> bool:
    """Whether a weight at a position sits on a disk at another, both m."""
    return abs(position - disk) <= ON_DISK
