"""Static loads of a rotor: share of its weight on each bearing, and buckling compression of its shaft.

A shaft that is pinned at its bearings buckles at the compression N at which K φ = N K_g φ has a solution. For a uniform beam on two
pins it is Euler's load π²EI/L², lowered by shear to 1/(L²/(π²EI) + 1/(κGA)) (F. Engesser; S. P. Timoshenko & J. M. Gere, Theory of
Elastic Stability, 1961, section 2.17).
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache

import numpy as np
import scipy

from ksmea.arrays import Array, Indices
from problems.rotor.finite_elements import shaft
from problems.rotor.finite_elements.assembly import assemble_free, chained, of_elements
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.mesh import DOF_PER_NODE
from problems.rotor.free_motion.stability import nominal_springs, ports_of

GRAVITY = 9.80665  # m/s², standard


def weight_shares(rotor: Rotor) -> Array:
    """Static load of each bearing, (n_bearing,) N, upwards positive.

    The rotor lies level on two bearings or more.

    Two bearings share it by levers alone. More share it as the shaft bends on springs as stiff as the bearings, all at one height.
    """
    ports, springs, deflection = _under_weight(rotor)
    return np.asarray(-(springs * deflection[ports])[1::2])


def static_sag(rotor: Rotor) -> Array:
    """Sag of the shaft below the line through its outer bearings under its weight, (n_node,) m.

    It is positive downwards.
    """
    _, _, deflection = _under_weight(rotor)
    down, nodes = -deflection[1::DOF_PER_NODE], rotor.node_positions
    held = np.unique([rotor.node_at(bearing.position, "bearing") for bearing in rotor.bearings])[[0, -1]]
    slope = (down[held[1]] - down[held[0]]) / (nodes[held[1]] - nodes[held[0]])
    return np.asarray(down - down[held[0]] - slope * (nodes - nodes[held[0]]))


def _under_weight(rotor: Rotor) -> tuple[Indices, Array, Array]:
    """Ports of the bearings, their springs N/m, and the deflection (n_dof,) m of the shaft.

    The shaft lies level on them.
    """
    free = assemble_free(rotor)
    ports, springs = ports_of(rotor, rotor.bearings), nominal_springs(rotor.bearings)
    stiffness = free.stiffness.copy()
    np.add.at(stiffness, (ports, ports), springs)
    down = np.tile([0.0, -1.0, 0.0, 0.0], len(stiffness) // DOF_PER_NODE)
    return ports, springs, np.linalg.solve(stiffness, GRAVITY * free.mass @ down)


def is_held(rotor: Rotor) -> bool:
    """Whether bearings at two places or more keep the shaft from turning over as a whole."""
    return len({rotor.node_at(bearing.position, "bearing") for bearing in rotor.bearings}) > 1


@lru_cache(maxsize=64)
def buckling_load(rotor: Rotor) -> float:
    """The least compression, N, under which a shaft buckles that `is_held`."""
    stiffness = assemble_free(dataclasses.replace(rotor, axial_force=0.0)).stiffness
    geometric = chained(of_elements(rotor, shaft.geometric_stiffness))
    pins = ports_of(rotor, rotor.bearings)
    free = np.setdiff1d(np.arange(len(stiffness)), pins)
    per_load = scipy.linalg.eigh(geometric[np.ix_(free, free)], stiffness[np.ix_(free, free)], eigvals_only=True)
    return float(1 / per_load[-1])
