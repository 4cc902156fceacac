"""Starts of effects that add to the readings.

Their unknowns enter linearly and are eliminated at every screened point.

With q(u) the response of the model without the effect and B θ what the effect adds, B the same at all u, the data are y ≈ a q(u) + B θ;
a is the common factor of all unbalance, complex if a common phase is free. At each point a and θ follow by least squares
(variable projection: G. H. Golub and V. Pereyra, Inverse Problems 19 (2003) R1, doi 10.1088/0266-5611/19/2/201), and points are ranked by
the part of the data that is left. So no value of θ has to be scanned, however many unknowns the effect has.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray, as_real
from ksmea.fits.starts import MAX_VALUES, scale_unbalance, turn, turning_angles
from ksmea.numerics.screening import Screened, ranked
from ksmea.problem.case import Case
from ksmea.problem.differences_problem import as_searched

LEAST_NORM = 1e-12  # of the basis, below which q lies in the span of B and says nothing


def eliminated(case: Case, points: Array, zero: Array) -> Screened:
    """Points (n, d) of a model's unit cube with the best unknowns (n, e) of its last effect, ranked.

    The unknowns suit complex data best. The rank is by the part of the data that remains; `zero` (e,) is where the
    effect is absent.
    """
    case = as_searched(case)
    problem, data = case.problem, case.measurement.values.ravel().astype(complex)
    basis = _added(case, points[0], zero)  # (m, e)
    angles, n_chunk = turning_angles(case), max(1, MAX_VALUES // data.size)
    found = []
    for start in range(0, len(points), n_chunk):
        chunk = points[start : start + n_chunk]
        x = problem.parameters.to_si(np.hstack([chunk, np.tile(zero, (len(chunk), 1))]))
        response = problem.response(x).reshape(len(x), -1)
        factor, sizes, misfit = _least_squares(response, basis, data, is_complex=bool(angles))
        scale_unbalance(problem, x, np.maximum(np.abs(factor), np.finfo(float).tiny))
        if angles:
            turn(x, angles, np.angle(factor))
        u = problem.parameters.to_cube(x)
        u[:, chunk.shape[1] :] += sizes
        found.append((np.clip(u, 0.0, 1.0), misfit))
    return ranked(*(np.concatenate(each) for each in zip(*found)))


def _added(case: Case, point: Array, zero: Array) -> Array:
    """Readings B (2 m, e) added per unit of each unknown in the unit cube.

    Real parts are above imaginary ones.
    """
    step = np.where(zero > 0.5, -0.5, 0.5)
    cube = np.tile(np.concatenate([point, zero]), (1 + len(zero), 1))
    cube[1:, len(point) :] += np.diag(step)
    readings = case.problem.response(case.problem.parameters.to_si(cube)).reshape(len(cube), -1)
    return as_real((readings[1:] - readings[0]) / step[:, None]).T


def _least_squares(
    response: ComplexArray, basis: Array, data: ComplexArray, *, is_complex: bool
) -> tuple[ComplexArray, Array, Array]:
    """Factor a (n,), unknowns θ (n, e) relative to `zero`, and remaining part (n,) of the data.

    They are for responses (n, m) and data (m,).
    """
    directions, triangle = np.linalg.qr(basis)
    of_data = directions.T @ as_real(data)
    left = as_real(data) - directions @ of_data
    columns = [as_real(response)] + ([as_real(1j * response)] if is_complex else [])
    own = [each - (each @ directions) @ directions.T for each in columns]  # off what the effect adds
    gram = np.stack([[np.sum(one * other, axis=1) for one in own] for other in own]).transpose(2, 0, 1)
    size = np.trace(gram, axis1=1, axis2=2)
    gram = gram + LEAST_NORM * np.maximum(size, np.finfo(float).tiny)[:, None, None] * np.eye(len(own))
    factors = np.linalg.solve(gram, np.stack([each @ left for each in own], axis=1)[..., None])[..., 0]
    rest = left - np.einsum("nk,knm->nm", factors, np.stack(own))
    used = np.einsum("nk,knm->nm", factors, np.stack(columns))
    sizes = np.linalg.solve(triangle, (of_data - used @ directions).T).T
    factor = factors[:, 0] + (1j * factors[:, 1] if is_complex else 0)
    misfit = np.sum(rest**2, axis=1) / np.sum(np.abs(data) ** 2)
    return factor, sizes, np.where(np.isfinite(misfit), misfit, np.inf)
