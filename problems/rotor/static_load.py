"""What each bearing carries of a rotor's weight."""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array
from problems.rotor.assembly import assemble_free, node_dof
from problems.rotor.data import Rotor
from problems.rotor.mesh import DOF_PER_NODE
from problems.rotor.stability import nominal_springs

GRAVITY = 9.80665  # m/s², standard


def weight_shares(rotor: Rotor) -> Array:
    """The static load of each bearing, (n_bearing,) N, upwards positive, of a rotor that lies level on two bearings or more.

    Two bearings share it by levers alone. More share it as the shaft bends on springs as stiff as the bearings, all at one height.
    """
    free = assemble_free(rotor)
    ports = np.concatenate([node_dof(rotor.node_at(bearing.position, "bearing"))[:2] for bearing in rotor.bearings])
    springs = nominal_springs(rotor)
    stiffness = free.stiffness.copy()
    stiffness[ports, ports] += springs
    down = np.tile([0.0, -1.0, 0.0, 0.0], len(stiffness) // DOF_PER_NODE)
    deflection = np.linalg.solve(stiffness, GRAVITY * free.mass @ down)
    return np.asarray(-(springs * deflection[ports])[1::2])
