"""Variable projection: starts of fits with the unbalance of each plane by least squares.

The response is linear in the unbalance.

At a point of all other unknowns the complex unbalances, and unknowns of effects such as a bow or a runout, are the solution of a weighted
linear least-squares problem, so that a screening covers the other unknowns alone (G. H. Golub & V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413–432, doi 10.1137/0710036). With
unbalance of two planes or more no common factor and phase (`ksmea/fits/starts.py`) suits the data.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array, Indices, as_real
from ksmea.fits.starts import MAX_VALUES
from ksmea.measurement.noise import Noise
from ksmea.numerics.screening import Screened, ranked
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem

NOTHING = np.empty(0, dtype=int)
LINEAR = (0.2, 0.6)  # parts of the limit of an unknown at which a response is compared with a straight line
EXACT = 1e-9  # of the change: rounding
FEWEST = 2  # planes: of one, a common factor and phase is the solution


def unbalance_planes(problem: Problem) -> list[tuple[int, int]]:
    """Indices of magnitude and phase of the unbalance of each plane.

    Empty unless all unknown unbalance is such pairs in different planes, and of two planes or more.
    """
    parameters = problem.parameters
    middle = parameters.to_si(np.full(len(parameters), 0.5))
    magnitudes = [index for index, item in enumerate(parameters) if item.is_unbalance]
    moved = {index: _moved(problem, middle, index) for index in range(len(parameters))}
    phases = {
        moved[index]: index for index, item in enumerate(parameters) if item.is_full_turn and len(moved[index]) == 1
    }
    pairs = [(index, phases[moved[index]]) for index in magnitudes if moved[index] in phases]
    is_complete = len(pairs) == len(magnitudes) == len({phase for _, phase in pairs}) >= FEWEST
    return pairs if is_complete else []


def _moved(problem: Problem, x: Array, index: int) -> tuple[float, ...]:
    """Positions (m) at which an unknown changes the unbalance."""
    changed = x.copy()
    changed[index] += problem.parameters.width[index] / 4
    before, after = problem.unbalance(x), problem.unbalance(changed)
    return tuple(position for position, size in after.items() if size != before.get(position, 0.0))


def linear_unknowns(problem: Problem, among: Indices) -> Indices:
    """Unknowns in which the response is linear, around 0 of them.

    Bows, runouts and forces that follow no motion.
    """
    middle = problem.parameters.to_si(np.full(len(problem.parameters), 0.5))
    middle[among] = 0.0
    found = []
    for index in among:
        once, twice = middle.copy(), middle.copy()
        once[index], twice[index] = np.multiply(LINEAR, problem.parameters.upper[index])
        at_rest, one, other = problem.response(np.stack([middle, once, twice]))
        gap = (other - at_rest) - LINEAR[1] / LINEAR[0] * (one - at_rest)
        if np.any(one != at_rest) and np.max(np.abs(gap)) < EXACT * np.max(np.abs(other - at_rest)):
            found.append(int(index))
    return np.array(found, dtype=int)


def projected(
    case: Case, noise: Noise, planes: Sequence[tuple[int, int]], points: Array, linear: Indices = NOTHING
) -> Screened:
    """Points (n, d) of the unit cube with linear unknowns fitted to complex data, best first.

    They are the unbalance of the planes, and other unknowns in which the response is linear. The misfit is the mean
    square of the residuals in standard deviations of the noise.
    """
    parameters, values = case.problem.parameters, case.measurement.values
    weight = 1 / noise.sd(np.abs(values))
    n_chunk = max(1, MAX_VALUES // values.size)
    parts = [
        _fitted(case, planes, weight, parameters.to_si(points[start : start + n_chunk]), linear)
        for start in range(0, len(points), n_chunk)
    ]
    x, misfit = (np.concatenate(each) for each in zip(*parts))
    return ranked(np.clip(parameters.to_cube(x), 0.0, 1.0), misfit)


def _fitted(
    case: Case, planes: Sequence[tuple[int, int]], weight: Array, x: Array, linear: Indices
) -> tuple[Array, Array]:
    """Points x (n, d) SI with their linear unknowns, and misfits (n,)."""
    magnitudes, phases = (list(each) for each in zip(*planes))
    x, unit, n_plane = x.copy(), case.problem.parameters.upper, len(planes)
    x[:, magnitudes] = x[:, phases] = 0.0
    x[:, linear] = 0.0
    without = case.problem.response(x)
    columns = []
    for index in (*magnitudes, *linear):
        alone = x.copy()
        alone[:, index] = unit[index]
        columns.append((weight * (case.problem.response(alone) - without)).reshape(len(x), weight.size))
    of_planes = [1j**turn * column for column in columns[:n_plane] for turn in (0, 1)]  # real and imaginary part
    basis = as_real(np.stack([*of_planes, *columns[n_plane:]], axis=-1), axis=1)
    target = as_real((weight * (case.measurement.values - without)).reshape(len(x), weight.size))
    size = np.einsum("nkm,nm->nk", np.linalg.pinv(basis), target)
    residual = target - np.einsum("nmk,nk->nm", basis, size)
    unbalance = size[:, : 2 * n_plane : 2] + 1j * size[:, 1 : 2 * n_plane : 2]
    x[:, magnitudes], x[:, phases] = np.abs(unbalance) * unit[magnitudes], np.angle(unbalance)
    x[:, linear] = size[:, 2 * n_plane :] * unit[linear]
    return x, np.mean(residual**2, axis=1)
