"""How large things are on a rotor, for limits of what is not known of it."""

from __future__ import annotations

import numpy as np

from problems.rotor.data import STIFFNESSES
from problems.rotor.problem import RotorProblem
from problems.rotor.unknowns import BearingTarget, UnbalanceTarget


def stiffness_scale(problem: RotorProblem) -> float:
    """The largest stiffness that a bearing has or may have, N/m."""
    limits = [
        item.parameter.upper
        for item in problem.unknowns
        for target in item.targets
        if isinstance(target, BearingTarget) and target.coefficient in STIFFNESSES
    ]
    return float(max([*limits, *(np.abs(bearing.stiffness).max() for bearing in problem.rotor.bearings)]))


def unbalance_scale(problem: RotorProblem) -> float:
    """The largest unbalance that a plane has or may have, kg m."""
    limits = [
        item.parameter.upper
        for item in problem.unknowns
        for target in item.targets
        if isinstance(target, UnbalanceTarget) and target.part == "magnitude"
    ]
    return float(max([*limits, *(plane.magnitude for plane in problem.rotor.unbalance)]))


def rotor_mass(problem: RotorProblem) -> float:
    """Mass of the shaft and its disks, kg."""
    rotor = problem.rotor
    shaft = sum(segment.material.density * segment.area * segment.length for segment in rotor.segments)
    return float(shaft + sum(disk.mass for disk in rotor.disks))
