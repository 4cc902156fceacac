"""Variable projection: starts of fits with the unbalance of each plane, in which the response is linear, by least squares.

At a point of all other unknowns the complex unbalances are the solution of a weighted linear least-squares problem, so that a screening
covers these other unknowns alone (G. H. Golub & V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413–432, doi 10.1137/0710036). With
unbalance of two planes or more no common factor and phase (`ksmea/fits/starts.py`) suits the data.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.fits.starts import MAX_VALUES
from ksmea.measurement.noise import Noise
from ksmea.numerics.screening import Screened, ranked
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem

FEWEST = 2  # planes: of one, a common factor and phase is the solution


def unbalance_planes(problem: Problem) -> list[tuple[int, int]]:
    """Indices of magnitude and phase of the unbalance of each plane; empty unless all unknown unbalance is such pairs in different
    planes, and of two planes or more."""
    parameters = problem.parameters
    middle = parameters.to_si(np.full(len(parameters), 0.5))
    magnitudes = [index for index, item in enumerate(parameters) if item.is_unbalance]
    moved = {index: _moved(problem, middle, index) for index in range(len(parameters))}
    phases = {moved[index]: index for index, item in enumerate(parameters) if item.is_full_turn and len(moved[index]) == 1}
    pairs = [(index, phases[moved[index]]) for index in magnitudes if moved[index] in phases]
    is_complete = len(pairs) == len(magnitudes) == len({phase for _, phase in pairs}) >= FEWEST
    return pairs if is_complete else []


def _moved(problem: Problem, x: Array, index: int) -> tuple[float, ...]:
    """Positions (m) at which an unknown changes the unbalance."""
    changed = x.copy()
    changed[index] += problem.parameters.width[index] / 4
    before, after = problem.unbalance(x), problem.unbalance(changed)
    return tuple(position for position, size in after.items() if size != before.get(position, 0.0))


def projected(case: Case, noise: Noise, planes: Sequence[tuple[int, int]], points: Array) -> Screened:
    """Points (n, d) of the unit cube with the unbalance of their planes fitted to complex data, best first; the misfit is the mean
    square of the residuals in standard deviations of the noise."""
    parameters, values = case.problem.parameters, case.measurement.values
    weight = 1 / noise.sd(np.abs(values))
    n_chunk = max(1, MAX_VALUES // values.size)
    parts = [
        _fitted(case, planes, weight, parameters.to_si(points[start : start + n_chunk]))
        for start in range(0, len(points), n_chunk)
    ]
    x, misfit = (np.concatenate(each) for each in zip(*parts))
    return ranked(np.clip(parameters.to_cube(x), 0.0, 1.0), misfit)


def _fitted(case: Case, planes: Sequence[tuple[int, int]], weight: Array, x: Array) -> tuple[Array, Array]:
    """Points x (n, d) SI with their unbalance, and misfits (n,)."""
    magnitudes, phases = (list(each) for each in zip(*planes))
    x, unit = x.copy(), case.problem.parameters.upper
    x[:, magnitudes] = x[:, phases] = 0.0
    without = case.problem.response(x)
    columns = []
    for magnitude in magnitudes:
        alone = x.copy()
        alone[:, magnitude] = unit[magnitude]
        columns.append(weight * (case.problem.response(alone) - without))
    basis: ComplexArray = np.stack(columns, axis=-1).reshape(len(x), weight.size, len(planes))
    target = (weight * (case.measurement.values - without)).reshape(len(x), weight.size)
    size = np.einsum("nkm,nm->nk", np.linalg.pinv(basis), target)
    residual = target - np.einsum("nmk,nk->nm", basis, size)
    x[:, magnitudes], x[:, phases] = np.abs(size) * unit[magnitudes], np.angle(size)
    return x, np.mean(np.abs(residual) ** 2, axis=1)
