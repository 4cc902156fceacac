"""Maximisation of many likelihoods as one batch, by the same damped Fisher scoring as `ksmea.inference.maximisation`.

It is for fits that start near their maxima and whose deviance is wanted to about a hundredth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ksmea.arrays import Array, Indices
from ksmea.likelihood.batched_likelihood import BatchedLikelihood

MAX_ITERATIONS = 60
LEAST_GAIN = 0.01  # of the deviance: a fit ends where a step is expected to give less, or gives less
FIRST_DAMPING, FIRST_RETRY, LAST_DAMPING = 1e-6, 1e-3, 1e4  # of a step, relative to the information
LEAST_SCALE = 1e-9  # of the largest: what the data tell nothing of


@dataclass(frozen=True)
class Fits:
    """Where fits ended: θ (k, p), the data set of each (k,), the deviance (k,) and the Fisher information near it (k, p, p)."""

    theta: Array
    sets: Indices
    deviance: Array
    information: Array

    def part(self, rows: Indices) -> Fits:
        """Some of them."""
        return Fits(self.theta[rows], self.sets[rows], self.deviance[rows], self.information[rows])

    def distinct(self, tolerance: float) -> Fits:
        """Those of each data set whose deviances differ by more than `tolerance`; the best of each where that is infinite."""
        rows = np.lexsort([self.deviance, self.sets])
        sets, deviance = self.sets[rows], self.deviance[rows]
        is_new = np.append(
            np.ones(min(len(rows), 1), dtype=bool), (np.diff(sets) > 0) | (np.diff(deviance) > tolerance)
        )
        return self.part(rows[is_new])

    def tangents(self, unknown: Indices) -> Array:
        """How θ moves with one unknown (k,) of each, all others fitted, (k, p)."""
        matrix, scale = _scaled(self.information)
        matrix = matrix + FIRST_DAMPING * np.eye(matrix.shape[1])
        own = np.arange(matrix.shape[1]) == unknown[:, None]
        others = np.where(own[:, :, None] | own[:, None], np.eye(matrix.shape[1]), matrix)
        follow = np.linalg.solve(others, np.where(own, -1.0, matrix[own])[..., None])[..., 0]
        return np.asarray(-follow * scale[own][:, None] / scale)


def batched_maxima(likelihood: BatchedLikelihood, theta: Array, sets: Indices, fixed: Indices | None = None) -> Fits:
    """The maxima within the limits that fits to data `sets` (k,) from θ (k, p) lead to.

    `fixed` (k,) is the index of an unknown that keeps its value in each fit; None: none does.
    """
    theta = np.clip(theta, likelihood.lower, likelihood.upper)
    deviance = likelihood.deviance(theta, sets)
    free = np.full(theta.shape, True)
    if fixed is not None:
        free[np.arange(len(theta)), fixed] = False
    gradient, information = np.empty(theta.shape), np.empty((*theta.shape, theta.shape[1]))
    damping = np.full(len(theta), FIRST_DAMPING)
    left = moved = np.arange(len(theta))
    for _ in range(MAX_ITERATIONS):
        if len(moved):
            gradient[moved], information[moved] = likelihood.scoring(theta[moved], sets[moved])
        step, expected = _steps(likelihood, theta[left], free[left], gradient[left], information[left], damping[left])
        left, step = left[expected > LEAST_GAIN], step[expected > LEAST_GAIN]
        if not len(left):
            break
        trial = np.clip(theta[left] + step, likelihood.lower, likelihood.upper)
        reached = likelihood.deviance(trial, sets[left])
        gain = deviance[left] - reached
        better = gain > 0
        theta[left[better]], deviance[left[better]] = trial[better], reached[better]
        damping[left] = np.where(
            better, np.maximum(damping[left] / 10, FIRST_DAMPING), np.maximum(damping[left] * 10, FIRST_RETRY)
        )
        goes_on = np.where(better, gain > LEAST_GAIN, damping[left] <= LAST_DAMPING)
        left, moved = left[goes_on], left[goes_on & better]
    return Fits(theta, sets, deviance, information)


def _steps(
    likelihood: BatchedLikelihood,
    theta: Array,
    free: NDArray[np.bool_],
    gradient: Array,
    information: Array,
    damping: Array,
) -> tuple[Array, Array]:
    """The steps (k, p) that lower the quadratic model of each deviance within the limits, and by how much: where a step meets a
    limit, that unknown stays there, and the others go on."""
    matrix, scale = _scaled(information)
    matrix = matrix + damping[:, None, None] * np.eye(matrix.shape[1])
    lower = np.maximum(likelihood.lower - theta, -likelihood.longest_step) * scale
    upper = np.minimum(likelihood.upper - theta, likelihood.longest_step) * scale
    half = gradient / scale / 2
    step = np.zeros(theta.shape)  # in units of 1 / scale
    for _ in range(theta.shape[1]):
        among = np.where(free[:, :, None] & free[:, None], matrix, np.eye(theta.shape[1]))
        rest = -half - (matrix @ np.where(free, 0.0, step)[..., None])[..., 0]
        ahead = np.linalg.solve(among, np.where(free, rest, step)[..., None])[..., 0] - step
        limit = np.where(ahead > 0, upper, lower)
        room = np.divide(limit - step, ahead, out=np.full(step.shape, np.inf), where=free & (ahead != 0))
        part = np.minimum(room.min(axis=1, keepdims=True), 1.0)
        meets = (room <= part) & (part < 1)
        step = np.where(meets, limit, step + part * ahead)
        free = free & ~meets
        if not np.any(meets):
            break
    expected = -2 * np.sum(half * step, axis=1) - np.einsum("kp,kpq,kq->k", step, matrix, step)
    return step / scale, expected


def _scaled(information: Array) -> tuple[Array, Array]:
    """Information (k, p, p) with a diagonal of 1, and what it was divided by (k, p) on both sides."""
    scale = np.sqrt(np.diagonal(information, axis1=1, axis2=2))
    scale = np.maximum(scale, LEAST_SCALE * scale.max(axis=1, keepdims=True))
    return information / (scale[:, :, None] * scale[:, None]), scale
