"""Responses of the three-disk rotor as numpy's own solver gives them.

All speeds in one call, nothing reduced.

The matrices of shaft and disks are assembled once; a set of unknowns changes the bearings' entries and the load. Sets go one
after the other: a hundred at once are 266 MB of matrices, and take three times as long for each.
"""

from __future__ import annotations

import numpy as np

from benchmarks.harness.task import Task
from benchmarks.tasks.three_disk import BEARING_NODES, N_COMPARED, PROBE_NODE, TRUTH, UNBALANCED_NODE, drawn, speeds
from problems.rotor.finite_elements.assembly import assemble_free
from problems.rotor.finite_elements.data import Rotor
from problems.three_disk import three_disk_rotor

DOF = 4  # of a node


def rotor_matrices(rotor: Rotor) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, G and K of the rotor without its bearings."""
    free = assemble_free(rotor)
    return np.asarray(free.mass), np.asarray(free.gyroscopic), np.asarray(free.stiffness)


class DenseModel:
    """The response of a rotor whose nodes lie at equal distances."""

    def __init__(self, n_speed: int) -> None:
        mass, gyroscopic, stiffness = rotor_matrices(three_disk_rotor(13))
        self.speed = speeds(n_speed)
        squared = self.speed[:, None, None] ** 2
        self.free = stiffness - squared * mass + 1j * squared * gyroscopic  # (n_speed, n_dof, n_dof)
        self.probe = [DOF * PROBE_NODE, DOF * PROBE_NODE + 1]

    def response(self, x: np.ndarray) -> np.ndarray:
        """(n, 5) SI → (n, n_speed, 2) m."""
        return np.stack([self._one(each) for each in x])

    def _one(self, x: np.ndarray) -> np.ndarray:
        whole = self.free.copy()
        for node in BEARING_NODES:
            for axis in (0, 1):
                dof = DOF * node + axis
                whole[:, dof, dof] += x[axis] + 1j * self.speed * x[2 + axis]
        force = np.zeros((*whole.shape[:2], 1), dtype=complex)
        size = x[4] * self.speed**2
        force[:, DOF * UNBALANCED_NODE, 0], force[:, DOF * UNBALANCED_NODE + 1, 0] = size, -1j * size
        return np.linalg.solve(whole, force)[:, self.probe, 0]


def evaluations(n_speed: int, batch: int, unit: int = 1) -> Task:
    """So many sets of unknowns; a unit is one, or as many as are named."""
    model, points = DenseModel(n_speed), drawn(batch)
    return Task(
        lambda turn: model.response(points), values=lambda _: model.response(drawn(N_COMPARED)), units=batch / unit
    )


def set_up(n_speed: int) -> Task:
    return Task(lambda turn: DenseModel(n_speed).response(TRUTH[None]), values=lambda found: found[0])
