"""Responses of the three-disk rotor from its four ports, as a script with numpy solves them.

The receptance of the rotor without bearings is computed once; a set of unknowns then costs a 4 × 4 system for each speed,
(Z⁻¹ + H) f = H₀ u, the forces of the bearings, and their effect at the probe. All sets and speeds go in one call.
"""
# Shorter than 40 lines: one way to do one row's work.

from __future__ import annotations

import numpy as np

from benchmarks.harness.task import Task
from benchmarks.tasks.fe_dense import DOF, DenseModel
from benchmarks.tasks.three_disk import BEARING_NODES, N_COMPARED, UNBALANCED_NODE, drawn

PORTS = [DOF * node + axis for node in BEARING_NODES for axis in (0, 1)]


class PortModel:
    def __init__(self, n_speed: int) -> None:
        model = DenseModel(n_speed)
        self.speed, n_dof = model.speed, model.free.shape[-1]
        force = np.zeros((n_speed, n_dof, 1), dtype=complex)
        force[:, DOF * UNBALANCED_NODE, 0] = self.speed**2
        force[:, DOF * UNBALANCED_NODE + 1, 0] = -1j * self.speed**2
        at_ports = np.broadcast_to(np.eye(n_dof)[:, PORTS], (n_speed, n_dof, len(PORTS)))
        motion = np.linalg.solve(model.free, np.concatenate([at_ports, force], axis=2))
        self.ports, self.probe = motion[:, PORTS], motion[:, model.probe]  # (n_speed, 4 or 2, 4 + 1)

    def response(self, x: np.ndarray) -> np.ndarray:
        """(n, 5) SI → (n, n_speed, 2) m."""
        yielding = 1 / (x[:, None, [0, 1, 0, 1]] + 1j * self.speed[:, None] * x[:, None, [2, 3, 2, 3]])
        system = self.ports[..., :4] + yielding[..., None] * np.eye(4)
        force = np.linalg.solve(system, np.broadcast_to(self.ports[..., 4:], (*system.shape[:3], 1)))
        return x[:, 4, None, None] * (self.probe[..., 4:] - self.probe[..., :4] @ force)[..., 0]


def evaluations(n_speed: int, batch: int) -> Task:
    model, points = PortModel(n_speed), drawn(batch)
    return Task(lambda turn: model.response(points), values=lambda _: model.response(drawn(N_COMPARED)), units=batch)
