"""Starts of fits: unbalance vectors and unknowns of an effect that enter linearly are solved for.

With magnitudes m_k and angles of unbalance, and θ of an effect such as a bow, the response at given bearings is
q = q_0 + Σ c_k m_k ∂q/∂m_k + Σ θ_j ∂q/∂θ_j, with complex factors c_k that scale and turn the vector of each plane. They
follow from complex data by least squares. A fit by magnitudes and angles has to go round a magnitude of 0: it would
stay at this limit.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray, as_real
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.units import TURN

TURNS_WITH = 0.5  # a vector's part of the change by an angle: it is all of the vector, or nothing


def solved_start(case: Case, u: Array, d: int, noise: Noise) -> Array:
    """Point (d + e,) of the unit cube with unbalance and the last e unknowns solved for.

    Complex data determine them, the others are unchanged. The point itself is returned if data are amplitudes or angles
    that are not free tie the vectors.
    """
    problem = case.problem
    parameters = problem.parameters
    magnitudes = [index for index, item in enumerate(parameters) if item.is_unbalance and index < d]
    angles = [index for index, item in enumerate(parameters) if item.is_full_turn and index < d]
    if case.measurement.is_amplitude or not (magnitudes and angles):
        return u
    x = parameters.to_si(u)
    x[magnitudes] = np.maximum(x[magnitudes], parameters.lower[magnitudes] + 0.1 * parameters.width[magnitudes])
    response, sensitivity = problem.linearised(x)
    weight = 1 / np.maximum(noise.sd(np.abs(response)), np.finfo(float).tiny)
    vectors = x[magnitudes] * sensitivity[..., magnitudes]
    effect = sensitivity[..., d:]
    turned = _turned(vectors, sensitivity[..., angles])  # (n_magnitude, n_angle)
    if np.linalg.matrix_rank(turned) < len(magnitudes):
        return u
    left = case.measurement.values - response + vectors.sum(axis=-1) + effect @ x[d:]
    columns = np.concatenate([vectors, 1j * vectors, effect], axis=-1)
    rows = as_real((columns * weight[..., None]).reshape(-1, columns.shape[-1]), axis=0)
    data = as_real((left * weight).ravel())
    scale = np.maximum(np.linalg.norm(rows, axis=0), np.finfo(float).tiny)
    solved = np.linalg.lstsq(rows / scale, data)[0] / scale
    n = len(magnitudes)
    factors = solved[:n] + 1j * solved[n : 2 * n]
    x[magnitudes] *= np.abs(factors)
    x[angles] += np.linalg.lstsq(turned, np.angle(factors))[0]
    x[angles] = (x[angles] + TURN / 2) % TURN - TURN / 2
    x[d:] = solved[2 * n :]
    return np.clip(parameters.to_cube(x), 0.0, 1.0)


def _turned(vectors: ComplexArray, by_angles: ComplexArray) -> Array:
    """Vectors (…, n_vector) that each angle turns, by the response per angle (…, n_angle).

    I times the sum of these, (n_vector, n_angle).
    """
    flat = 1j * vectors.reshape(-1, vectors.shape[-1])
    scale = np.maximum(np.linalg.norm(flat, axis=0), np.finfo(float).tiny)
    parts = np.linalg.lstsq(flat / scale, by_angles.reshape(-1, by_angles.shape[-1]))[0] / scale[:, None]
    return np.asarray(np.sign(parts.real) * (np.abs(parts) > TURNS_WITH))
