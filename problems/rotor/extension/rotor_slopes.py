"""Derivatives of the motion seen by probes with respect to unknowns of the rotor itself.

These unknowns change the rotor, load it otherwise, or move probes.

With D q = f and rows r that read q, dq_seen = dr q + r D⁻¹ (df − dD q): rows r D⁻¹ and motion q of one factorisation serve all unknowns.
dD is the difference of two rotors' matrices. Of unknowns in which the matrices are linear it is exact, and the same at all values of
such unknowns, so that it is computed once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel
from ksmea.numerics.differences import recent
from ksmea.problem.load import Load
from problems.rotor.extension.matrix_slope import MatrixSlope
from problems.rotor.extension.with_effects import RotorWithEffects
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import force_per_unbalance
from problems.rotor.finite_elements.mesh import DOF_PER_NODE
from problems.rotor.response.dense import channel_rows
from problems.rotor.response.links import LinksOfShaft, links_of, on_their_pedestals, read_housings
from problems.rotor.response.receptance import stiffness_band

# Of differences of what effects do, in parts of each unknown's range: (1e-6)² and rounding of 1e-16 / 1e-6 or 1e-12 / 1e-6
STEP = 1e-6
MATRIX_STEP = 1e-4  # of matrices of a rotor, of which a number may be a small part
LINEAR_STEP = 0.01  # where the difference is exact
PROBE_STEP = 1e-4  # directions of channels have 1e-9 degrees
# Kept: those of unknowns in which the matrices are linear, by all other values; so many, and so many numbers in all
FEWEST_SLOPES, MAX_SLOPE_NUMBERS = 64, 2**22


@dataclass(frozen=True, eq=False)
class WholeShaft:
    """A rotor with effects at one set of values, by the degrees of freedom of its whole shaft."""

    problem: RotorWithEffects
    rotor: Rotor
    channels: tuple[Channel, ...]  # where their probes are
    impedance: ComplexArray  # (n_impedance, n_speed) N/m
    unit_loads: tuple[Load, ...] = ()  # beside those of its effects

    @property
    def speed(self) -> Array:
        return self.problem.base.speed

    def stiffness(self) -> ComplexArray:
        """The dynamic stiffness as a band."""
        return stiffness_band(self.rotor, self.links, self.speed)

    @cached_property
    def links(self) -> LinksOfShaft:
        bearings = on_their_pedestals(self.rotor, self.problem.impedances, self.impedance, self.speed)
        readings, n_dof = (
            read_housings(self.rotor, self.channels),
            DOF_PER_NODE * len(self.rotor.node_positions),
        )
        return LinksOfShaft(bearings, links_of(self.problem.impedances), readings, n_dof, len(self.speed))

    def rows(self) -> Array | ComplexArray:
        """Rows that read the probes, ([n_speed,] n_channel, n_dof)."""
        return self.links.reading_rows(channel_rows(self.rotor, self.channels))

    def forces(self) -> ComplexArray:
        """Nodal forces of all loads, (n_speed, n_dof, n_load)."""
        further = self.problem.further_forces(self.rotor, self.unit_loads)
        of_unbalance = force_per_unbalance(self.rotor, self.speed)
        return of_unbalance if further is None else np.concatenate([of_unbalance, further], axis=2)

    def force_of_bearings(self, motion: ComplexArray) -> ComplexArray:
        """Forces that hold bearings and seals against a motion (n_speed, n_dof, n_column)."""
        total = np.zeros_like(motion)
        for bearing in self.links.bearings:
            total[:, bearing.dof] += bearing.rows.T @ (bearing.felt @ (bearing.rows @ motion[:, bearing.dof]))
        return total


def seen_changes(
    shaft: WholeShaft, x: Array, motion: ComplexArray, rows: ComplexArray, weights: ComplexArray
) -> dict[int, ComplexArray]:
    """Derivatives ∂(seen motion)/∂x (n_seen, n_column, n_speed) by each costly unknown of a shaft.

    They are at x (d,) SI, from its motion (n_speed, n_dof, n_column) and the rows times D⁻¹ (n_speed, n_seen, n_dof).
    """
    problem = shaft.problem
    speed, (n_speed, n_dof, n_column) = problem.base.speed, motion.shape
    push = np.zeros((n_speed, n_dof, len(problem.costly), n_column), dtype=complex)
    read = {}
    for place, unknown in enumerate(map(int, problem.costly)):
        if problem.of_probes[unknown]:
            read[place] = _read_change(shaft, x, unknown, motion)
            continue
        slope = slope_at(problem, x, unknown)
        push[:, slope.dof, place] -= slope.times(speed, motion)
        if not problem.linear[unknown] or problem.loads_follow_rotor:
            below, above, width = _ends(shaft, x, unknown, MATRIX_STEP)
            if not problem.loads_follow_rotor and _differ_in_inertia_alone(below.rotor, above.rotor):
                continue
            push[:, :, place] -= (above.force_of_bearings(motion) - below.force_of_bearings(motion)) / width
            push[:, :, place] += (above.forces() - below.forces()) @ weights / width
            read[place] = (above.rows() - below.rows()) @ motion / width
    seen = (rows @ push.reshape(n_speed, n_dof, -1)).reshape(n_speed, -1, len(problem.costly), n_column)
    for place, change in read.items():
        seen[:, :, place] += change
    return {int(unknown): seen[:, :, place].transpose(1, 2, 0) for place, unknown in enumerate(problem.costly)}


def _differ_in_inertia_alone(one: Rotor, other: Rotor) -> bool:
    """Whether two rotors differ in disks and lumped masses alone.

    These neither load the shaft nor read or hold it.
    """
    return dataclasses.replace(one, disks=other.disks, masses=other.masses) == other


def _read_change(shaft: WholeShaft, x: Array, unknown: int, motion: ComplexArray) -> ComplexArray:
    """∂(seen motion)/∂x (n_speed, n_seen, n_column) by an unknown that moves probes alone."""
    problem = shaft.problem
    if problem.base.rotor.housing_probes:
        first, second, width = _ends(shaft, x, unknown, PROBE_STEP)
        return np.asarray((second.rows() - first.rows()) @ motion / width)
    below, above = ends(problem, x, unknown, PROBE_STEP)
    before, after = (problem.channels_with(end[problem.costly]) for end in (below, above))
    found = np.zeros((len(motion), len(before), motion.shape[2]), dtype=complex)
    moved = [index for index, each in enumerate(before) if each != after[index]]
    if moved:
        lower, upper = (channel_rows(shaft.rotor, [channels[index] for index in moved]) for channels in (before, after))
        found[:, moved] = (upper - lower) @ motion / (above[unknown] - below[unknown])
    return found


def slope_at(problem: RotorWithEffects, x: Array, unknown: int) -> MatrixSlope:
    """∂/∂x of the matrices with one unknown.

    Parts that depend on no other changed value are known already.
    """
    others = np.where(problem.of_probes, 0.0, x)[problem.costly]
    if problem.linear[unknown]:
        others[problem.linear[problem.costly]] = 0.0
    place = int(np.searchsorted(problem.costly, unknown))
    key: Hashable = (problem.changing_rotor, place, others.tobytes())
    kept = problem.base.slopes_beside_effects
    n_dof = DOF_PER_NODE * len(problem.base.rotor.node_positions)
    most = max(FEWEST_SLOPES, MAX_SLOPE_NUMBERS // n_dof**2)
    return recent(kept, key, lambda: _new_slope(problem, x, unknown), most)


def _new_slope(problem: RotorWithEffects, x: Array, unknown: int) -> MatrixSlope:
    is_linear = problem.linear[unknown]
    below, above = ends(problem, x, unknown, LINEAR_STEP if is_linear else MATRIX_STEP)
    if is_linear and above[unknown] > x[unknown]:
        below = x  # whose rotor is there already
    rotors = problem.rotor_with(below), problem.rotor_with(above)
    return MatrixSlope.between(*rotors, float(above[unknown] - below[unknown]))


def ends(problem: RotorWithEffects, x: Array, unknown: int, step: float) -> tuple[Array, Array]:
    """x with one unknown on both sides of its value, within its limits."""
    parameter = problem.parameters.items[unknown]
    by = step * (parameter.upper - parameter.lower)
    below, above = x.copy(), x.copy()
    below[unknown] = max(x[unknown] - by, parameter.lower)
    above[unknown] = min(x[unknown] + by, parameter.upper)
    return below, above


def _ends(shaft: WholeShaft, x: Array, unknown: int, step: float) -> tuple[WholeShaft, WholeShaft, float]:
    """The shaft on both sides of an unknown's value, and their distance."""
    problem = shaft.problem
    below, above = ends(problem, x, unknown, step)
    first, second = (
        WholeShaft(
            problem,
            problem.rotor_with(end),
            problem.channels_with(end[problem.costly]),
            shaft.impedance,
            shaft.unit_loads,
        )
        for end in (below, above)
    )
    return first, second, float(above[unknown] - below[unknown])
