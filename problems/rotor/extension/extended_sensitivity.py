"""Response and sensitivity of an extended rotor from one solution of it, whatever its effects change.

The rotor obeys D q = F s, with loads F of sizes s. Where a row c reads the motion, a change of the model is seen as

    c dq = yᵀ (dF s − dD q) + c D⁻¹ F ds,    Dᵀ y = c,

so that motion and adjoint rows at one point are enough for all unknowns. Impedances change D at the ports alone, where the
receptances have both. An effect that changes the rotor changes D and F anywhere: motion and rows are then solved for over the
whole shaft, with one factorisation per speed.

What effects themselves do is differenced: impedances, sizes of loads, matrices of the rotor, and what forces by laws and probes
make of the motion. These are small arrays, and no rotor is solved for them.

Sign convention: real quantities are Re(· e^{iΩt}); a bearing pushes the shaft with −z q.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from ksmea.arrays import Array, ComplexArray
from ksmea.numerics.differences import CentralDifferences, central_differences
from problems.rotor.extension.with_effects import RotorWithEffects
from problems.rotor.finite_elements.assembly import assemble_free
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import force_per_unbalance
from problems.rotor.response.banded import dynamic_stiffness_band, solve_both_ways
from problems.rotor.response.dense import channel_rows
from problems.rotor.response.links import LinksOfShaft, add_to_band, links_of, on_their_pedestals, read_housings

STEP = 1e-6  # of differences, in parts of each unknown's range: (1e-6)² and rounding of 1e-16 / 1e-6 or 1e-12 / 1e-6


@dataclass(frozen=True, eq=False)
class Solution:
    """A rotor at one point. Its `columns` are the motion, and what unit forces at the sites of laws move."""

    seen: ComplexArray  # response of the seen channels to each load (n_seen, n_load, n_speed)
    seen_per_port: ComplexArray  # and to unit forces at the ports (n_seen, n_port, n_speed), m/N
    columns_at_ports: ComplexArray  # (n_port, n_column, n_speed)
    by_rotor: Mapping[int, ComplexArray]  # ∂columns/∂x at the seen channels, by unknown (n_seen, n_column, n_speed)


def linearised(problem: RotorWithEffects, x: Array) -> tuple[ComplexArray, ComplexArray]:
    """Response (n_speed, n_channel) and sensitivity (n_speed, n_channel, d), m per SI unit, at x (d,) SI."""
    parameters = problem.parameters
    differences = central_differences(x, STEP * parameters.width, parameters.lower, parameters.upper)
    points = np.concatenate([x[None], differences.points])
    impedance, sizes = problem.impedances_and_sizes(points)
    n_own = sizes.shape[1]
    n_unit = sum(len(each.loads) for each in problem.site_laws)
    weights = block_diag(sizes[0][:, None], np.eye(n_unit))  # of the loads in each column
    solve = _over_shaft if len(problem.costly) else _at_ports
    solution = solve(problem, x, impedance[:, 0], weights)

    columns = np.einsum("rls,lc->rcs", solution.seen, weights)
    change = np.zeros((len(x), *columns.shape), dtype=complex)  # (d, n_seen, n_column, n_speed)
    change[:, :, 0] = np.einsum("rls,lk->krs", solution.seen[:, :n_own], differences.derivative(sizes[1:]))
    by_impedance = np.moveaxis(differences.derivative(np.moveaxis(impedance[:, 1:], 1, 0)), -1, 0)
    for index, item in enumerate(problem.impedances):
        moved = np.flatnonzero(np.any(by_impedance[:, index], axis=1))
        push = solution.seen_per_port[:, item.row_port, None] * solution.columns_at_ports[item.column_port]
        change[moved] -= push * by_impedance[moved, index, None, None]
    for unknown, by_unknown in solution.by_rotor.items():
        change[unknown] += by_unknown
    return _shown(problem, points, differences, columns.transpose(2, 0, 1), change.transpose(0, 3, 1, 2))


def _shown(
    problem: RotorWithEffects,
    points: Array,
    differences: CentralDifferences,
    columns: ComplexArray,
    change: ComplexArray,
) -> tuple[ComplexArray, ComplexArray]:
    """What the probes show, with forces by laws acting, of columns (n_speed, n_seen, n_column) and their change (d, …)."""
    if problem.shows_motion:
        n_channel = len(problem.base.channels)
        return columns[:, :n_channel, 0], np.moveaxis(change[:, :, :n_channel, 0], 0, -1)
    steps = np.sum(points[1:] - points[0], axis=1)  # each point differs in one unknown
    around = columns + steps[:, None, None, None] * np.concatenate([change, change])
    shown = problem.shown(np.concatenate([columns[None], around]), points)
    return shown[0], differences.derivative(shown[1:])


def _at_ports(problem: RotorWithEffects, x: Array, impedance: ComplexArray, weights: ComplexArray) -> Solution:
    """With impedances (n_impedance, n_speed), by the receptances of a rotor that no unknown changes."""
    reduction = problem.reduction((), ())
    receptance, n_port = reduction.receptance_on(impedance), reduction.n_port
    columns_at_ports = np.einsum("pls,lc->pcs", receptance[:n_port, n_port:], weights)
    return Solution(receptance[n_port:, n_port:], receptance[n_port:, :n_port], columns_at_ports, {})


def _over_shaft(problem: RotorWithEffects, x: Array, impedance: ComplexArray, weights: ComplexArray) -> Solution:
    """The same where unknowns change the rotor, by the motion of the whole shaft."""
    rotor = problem.rotor_with(x)
    forces = _forces(problem, rotor)  # (n_speed, n_dof, n_load)
    speed, channels = problem.base.speed, problem.seen_channels
    bearings = on_their_pedestals(rotor, problem.impedances, impedance, speed)
    stiffness = dynamic_stiffness_band(assemble_free(rotor), speed)
    add_to_band(stiffness, bearings)
    readings, n_dof = read_housings(rotor, channels), stiffness.shape[1]
    links = LinksOfShaft(bearings, links_of(problem.impedances), readings, n_dof, len(speed))
    motion, rows = solve_both_ways(stiffness, forces @ weights, links.reading_rows(channel_rows(rotor, channels)))
    seen_per_port = rows @ links.port_forces() + links.beside_shaft(len(channels))[:, -len(channels) :]
    by_rotor = {}
    for unknown in problem.costly:
        changed = _rotor_change(problem, x, unknown, motion, weights)
        by_rotor[int(unknown)] = (rows @ changed).transpose(1, 2, 0)
    return Solution(
        (rows @ forces).transpose(1, 2, 0),
        seen_per_port.transpose(1, 2, 0),
        (links.port_rows() @ motion).transpose(1, 2, 0),
        by_rotor,
    )


def _rotor_change(
    problem: RotorWithEffects, x: Array, unknown: int, motion: ComplexArray, weights: ComplexArray
) -> ComplexArray:
    """∂F/∂x s − ∂D/∂x q with one unknown, of the columns (n_speed, n_dof, n_column)."""
    parameter = problem.parameters.items[unknown]
    step = STEP * (parameter.upper - parameter.lower)
    ends = np.clip(x[unknown] + np.array([-step, step]), parameter.lower, parameter.upper)
    below, above = (problem.rotor_with(np.where(np.arange(len(x)) == unknown, end, x)) for end in ends)
    width = ends[1] - ends[0]
    force = (_forces(problem, above) - _forces(problem, below)) @ weights
    return np.asarray((force - _stiffness_change(below, above, problem.base.speed, motion)) / width)


def _forces(problem: RotorWithEffects, rotor: Rotor) -> ComplexArray:
    """Nodal forces of all loads, (n_speed, n_dof, n_load)."""
    further = problem.further_forces(rotor, ())
    return np.concatenate(
        [force_per_unbalance(rotor, problem.base.speed), *([] if further is None else [further])], axis=2
    )


def _stiffness_change(below: Rotor, above: Rotor, speed: Array, motion: ComplexArray) -> ComplexArray:
    """The difference of two rotors' dynamic stiffness (`dense.dynamic_stiffness`) times a motion (n_speed, n_dof, n_column)."""
    first, second = assemble_free(below), assemble_free(above)
    omega = speed[:, None, None]
    factors = {
        "stiffness": np.ones_like(omega),
        "circulatory": omega,
        "mass": -(omega**2),
        "damping": 1j * omega,
        "gyroscopic": 1j * omega**2,
    }
    total = np.zeros_like(motion)
    before, after = first.hysteresis(1.0), second.hysteresis(1.0)
    if before is not None and after is not None:
        total += (after[0] - before[0] + 1j * (after[1] - before[1])) @ motion
    for name, factor in factors.items():
        matrix = getattr(second, name) - getattr(first, name)
        if np.any(matrix):
            total += factor * (matrix @ motion)
    return total
