"""Response and sensitivity of an extended rotor from one solution of it, whatever its effects change.

The rotor obeys D q = F s, with loads F of sizes s. In the motion that a row c reads, a change of the model is seen as

    c dq = yᵀ (dF s − dD q) + c D⁻¹ F ds,    Dᵀ y = c,

so that motion and adjoint rows at one point are enough for all unknowns. Impedances change D at the ports alone, and
the receptances have both there; so they do at the few places at which a disk or hub changes D. Any other effect that changes
the rotor changes D and F anywhere: motion and rows are then solved for over the whole shaft, with one factorisation per speed.

What effects themselves do is differenced: impedances, sizes of loads, matrices of the rotor, and what forces by laws and probes
make of the motion. These are small arrays, and no rotor is solved for them.

Sign convention: real quantities are Re(· e^{iΩt}); a bearing pushes the shaft with −z q.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.numerics.differences import CentralDifferences, central_differences
from ksmea.problem.load import Load
from problems.rotor.extension.local_change import LocalChanges
from problems.rotor.extension.rotor_slopes import PROBE_STEP, STEP, WholeShaft, ends, seen_changes, slope_at
from problems.rotor.extension.with_effects import RotorWithEffects
from problems.rotor.response.banded import solve_both_ways
from problems.rotor.response.receptance import Reduction


@dataclass(frozen=True, eq=False)
class Solution:
    """A rotor at one point. Its `columns` are the motion, and what unit forces at the sites of laws move."""

    seen: ComplexArray  # response of the seen channels to each load (n_seen, n_load, n_speed)
    seen_per_port: ComplexArray  # and to unit forces at the ports (n_seen, n_port, n_speed), m/N
    columns_at_ports: ComplexArray  # (n_port, n_column, n_speed)
    costly: Mapping[int, ComplexArray]  # ∂columns/∂x at the seen channels, by unknown (n_seen, n_column, n_speed)


def linearised(problem: RotorWithEffects, x: Array, loads: tuple[Load, ...] = ()) -> tuple[ComplexArray, ComplexArray]:
    """Response and responses to unit loads with their sensitivity at x (d,) SI.

    They are (n_speed, n_channel, 1 + n_load) and (…, d), m and m per unit, per SI unit.
    """
    parameters = problem.parameters
    differences = central_differences(x, STEP * parameters.width, parameters.lower, parameters.upper)
    points = np.concatenate([x[None], differences.points])
    impedance, sizes = problem.impedances_and_sizes(points)
    n_own, n_unit = sizes.shape[1], len(problem.unit_loads_with(loads))
    weights = np.zeros((n_own + n_unit, 1 + n_unit), dtype=complex)  # of the loads in each column
    weights[:n_own, 0], weights[n_own:, 1:] = sizes[0], np.eye(n_unit)
    solution = _solution(problem, x, impedance[:, 0], weights, loads)

    columns = np.einsum("rls,lc->rcs", solution.seen, weights)
    change = np.zeros((len(x), *columns.shape), dtype=complex)  # (d, n_seen, n_column, n_speed)
    change[:, :, 0] = np.einsum("rls,lk->krs", solution.seen[:, :n_own], differences.derivative(sizes[1:]))
    by_impedance = np.moveaxis(differences.derivative(np.moveaxis(impedance[:, 1:], 1, 0)), -1, 0)
    for index, item in enumerate(problem.impedances):
        moved = np.flatnonzero(np.any(by_impedance[:, index], axis=1))
        push = solution.seen_per_port[:, item.row_port, None] * solution.columns_at_ports[item.column_port]
        change[moved] -= push * by_impedance[moved, index, None, None]
    for unknown, by_unknown in solution.costly.items():
        change[unknown] += by_unknown
    return _shown(problem, points, differences, columns.transpose(2, 0, 1), change.transpose(0, 3, 1, 2))


def _shown(
    problem: RotorWithEffects,
    points: Array,
    differences: CentralDifferences,
    columns: ComplexArray,
    change: ComplexArray,
) -> tuple[ComplexArray, ComplexArray]:
    """Readings of the probes with forces by laws acting, for columns and their change.

    The columns are (n_speed, n_seen, n_column), the change (d, …).
    """
    if problem.shows_motion:
        n_channel = len(problem.base.channels)
        return columns[:, :n_channel], np.moveaxis(change[:, :, :n_channel], 0, -1)
    steps = np.sum(points[1:] - points[0], axis=1)  # each point differs in one unknown
    around = columns + steps[:, None, None, None] * np.concatenate([change, change])
    shown = problem.shown(np.concatenate([columns[None], around]), points)
    return shown[0], differences.derivative(shown[1:])


def _solution(
    problem: RotorWithEffects, x: Array, impedance: ComplexArray, weights: ComplexArray, loads: tuple[Load, ...]
) -> Solution:
    """Solution with impedances (n_impedance, n_speed), by the cheapest route that serves the effects."""
    if np.all(problem.of_probes[problem.costly]):
        return _at_ports(problem, x, impedance, weights, loads)
    known = problem.at_changes(tuple(x[problem.costly]), loads)
    local = None if known is None else _at_changes(problem, x, *known, impedance, weights)
    return _over_shaft(problem, x, impedance, weights, loads) if local is None else local


def _at_ports(
    problem: RotorWithEffects, x: Array, impedance: ComplexArray, weights: ComplexArray, loads: tuple[Load, ...]
) -> Solution:
    """Solution by the receptances of a rotor whose probes alone may move."""
    reduction = problem.reduction(tuple(x[problem.costly]), loads)
    n_port, n_row = reduction.n_port, len(reduction.receptance)
    slopes = [_probe_slope(problem, x, unknown, loads)[n_port:] for unknown in problem.costly]  # rows like any others
    whole = dataclasses.replace(reduction, receptance=np.concatenate([reduction.receptance, *slopes]))
    receptance = whole.receptance_on(impedance)
    seen, *by_probes = np.split(receptance[n_port:, n_port:], len(slopes) + 1)
    costly = {int(unknown): np.einsum("rls,lc->rcs", each, weights) for unknown, each in zip(problem.costly, by_probes)}
    columns_at_ports = np.einsum("pls,lc->pcs", receptance[:n_port, n_port:], weights)
    return Solution(seen, receptance[n_port:n_row, :n_port], columns_at_ports, costly)


def _probe_slope(problem: RotorWithEffects, x: Array, unknown: int, loads: tuple[Load, ...]) -> ComplexArray:
    """∂/∂x of the receptances about nominal bearings by an unknown that moves probes."""
    below, above = ends(problem, x, unknown, PROBE_STEP)
    first, second = (problem.reduction(tuple(end[problem.costly]), loads).receptance for end in (below, above))
    return np.asarray((second - first) / (above[unknown] - below[unknown]))


def _at_changes(
    problem: RotorWithEffects,
    x: Array,
    changes: LocalChanges,
    reduction: Reduction,
    impedance: ComplexArray,
    weights: ComplexArray,
) -> Solution | None:
    """Solution by the receptances of a rotor, seen also from the few places at which unknowns change it.

    None if a derivative touches other places.
    """
    n_port, n = reduction.n_port, len(changes.dof)
    receptance = reduction.receptance_on(impedance)
    loaded = receptance[:, n_port:-n]
    seen, at_dof = loaded[n_port:-n], np.einsum("als,lc->sac", loaded[-n:], weights)
    costly = {}
    for unknown in map(int, problem.costly):
        slope = slope_at(problem, x, unknown)
        if (place := changes.places_of(slope.dof)) is None:
            return None
        push = dataclasses.replace(slope, dof=place).times(problem.base.speed, at_dof)
        costly[unknown] = -np.einsum("ras,sac->rcs", receptance[n_port:-n, -n:][:, place], push)
    columns_at_ports = np.einsum("pls,lc->pcs", loaded[:n_port], weights)
    return Solution(seen, receptance[n_port:-n, :n_port], columns_at_ports, costly)


def _over_shaft(
    problem: RotorWithEffects, x: Array, impedance: ComplexArray, weights: ComplexArray, loads: tuple[Load, ...]
) -> Solution:
    """Solution for a rotor that unknowns change, by the motion of the whole shaft."""
    shaft = WholeShaft(problem, problem.rotor_with(x), problem.channels_with(x[problem.costly]), impedance, loads)
    forces = shaft.forces()  # (n_speed, n_dof, n_load)
    links = shaft.links
    motion, rows = solve_both_ways(shaft.stiffness(), forces @ weights, shaft.rows())
    n_seen = rows.shape[1]
    seen_per_port = rows @ links.port_forces()
    if not links.is_on_ground:
        seen_per_port = seen_per_port + links.beside_shaft(n_seen)[:, -n_seen:]
    return Solution(
        (rows @ forces).transpose(1, 2, 0),
        seen_per_port.transpose(1, 2, 0),
        (links.port_rows() @ motion).transpose(1, 2, 0),
        seen_changes(shaft, x, motion, rows, weights),
    )
