"""A model with something unknown in it that is free at every speed.

A force at a site, a moment, or a reading at a plane.

At one speed, with y (n_channel,) the measured response and q(x) the response of the model with unknowns x,

    y = q(x) + A(x) f + noise,

where A (n_channel, k) is the response to unit forces in x and y at the site – or picks the probes of a plane – and f (k,)
is complex and may be anything. Whatever acts there, linear or not, has this form at the true x as far as it turns with
the shaft. f enters linearly and is eliminated speed by speed (variable projection): with s the noise, the projected residual

    r(x) = (1 − Ã Ã⁺) (q − y) / s,    Ã = A / s,

depends on x alone. Its Jacobian is the Jacobian of q + A f with f held, projected alike (Kaufman's approximation, which leaves
the gradient exact).

G. H. Golub and V. Pereyra, Inverse Problems 19 (2003) R1–R26, doi 10.1088/0266-5611/19/2/201; L. Kaufman, BIT 15 (1975)
49–57, doi 10.1007/BF01932995.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray, Mask
from ksmea.likelihood.fisher import Point, with_prior_rows
from ksmea.likelihood.likelihood import BEND
from ksmea.measurement.channel import DIRECTIONS, Channel
from ksmea.problem.case import Case
from ksmea.problem.held import HeldProblem
from ksmea.problem.load import FORCE, LOADS, Load
from ksmea.problem.problem import Problem
from ksmea.records.location import LATERAL, PAIR

READING = "reading"
QUANTITIES = (*LOADS, LATERAL, READING)

# Part of its effect on the data that an unknown must keep beside f. Where derivatives are differences of the response they have
# errors of 1e-9, and an unbalance at the very site keeps none.
LEAST_KEPT = 1e-6


@dataclass(frozen=True)
class Unmodelled:
    """Quantity (one of `QUANTITIES`) at a position (m) that the model lacks.

    If it is None, nothing is missing.

    A pair of forces also acts at a second position.
    """

    quantity: str | None = None
    position: float = 0.0
    second: float | None = None

    def __str__(self) -> str:
        places = " and ".join(f"{position:g} m" for position in self.positions)
        return "nothing" if self.quantity is None else f"{self.quantity} at {places}"

    @property
    def positions(self) -> tuple[float, ...]:
        return (self.position,) if self.second is None else (self.position, self.second)

    @property
    def loads(self) -> tuple[Load, ...]:
        """The loads on the shaft that it consists of, in the order of f."""
        quantities = LOADS if self.quantity == LATERAL else (FORCE,) if self.quantity == PAIR else (self.quantity,)
        return tuple(
            Load(position, axis, quantity)
            for position in self.positions
            for quantity in quantities
            if quantity in LOADS
            for axis in DIRECTIONS
        )

    def named_columns(self, problem: Problem) -> tuple[tuple[str, str], ...]:
        """Direction and unit of each part of f."""
        if self.quantity == LATERAL:
            return tuple((f"{load.quantity} {load.direction}", load.unit) for load in self.loads)
        if self.quantity == PAIR:
            return tuple((f"{load.direction} at {load.position:g} m", load.unit) for load in self.loads)
        if self.loads:
            return tuple((load.direction, load.unit) for load in self.loads)
        return tuple((channel.direction, "m") for channel in problem.channels if self.reads(channel))

    def reads(self, channel: Channel) -> bool:
        """Whether what is unknown is the reading of this probe."""
        return self.quantity == READING and channel.position == self.position

    def columns(self, problem: Problem, x: Array) -> ComplexArray:
        """A at sets x (n, d), (n, n_speed, n_channel, k)."""
        return self.response_and_columns(problem, x)[1]

    def response_and_columns(self, problem: Problem, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """q (n, n_speed, n_channel) and A (n, n_speed, n_channel, k) at sets x (n, d)."""
        if self.loads:
            return problem.response_and_per_load(x, self.loads)
        response = problem.response(x)
        return response, self._read(problem, response.shape)

    def linearised(self, problem: Problem, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """q and A side by side at x (d,), (n_speed, n_channel, 1 + k), and their derivatives (…, d)."""
        columns, change = problem.linearised_per_load(x, self.loads)
        if self.loads:
            return columns, change
        read = self._read(problem, columns.shape[:2])
        same = np.zeros((*read.shape, len(x)), dtype=complex)
        return np.concatenate([columns, read], axis=2), np.concatenate([change, same], axis=2)

    def _read(self, problem: Problem, shape: tuple[int, ...]) -> ComplexArray:
        """Contribution of each unknown reading to a response of a shape (…, n_channel), (…, n_channel, k)."""
        read = [self.reads(channel) for channel in problem.channels]
        return np.broadcast_to(np.eye(len(read), dtype=complex)[:, read], (*shape, sum(read)))


@dataclass(frozen=True)
class ProjectedPoint(Point):
    """The projected likelihood at a point, with what was eliminated."""

    free: ComplexArray  # f (n_speed, k): N, N m, or m of a reading
    basis: ComplexArray  # of what Ã spans (n_speed, n_channel, k)
    columns: ComplexArray  # A (n_speed, n_channel, k)
    response: ComplexArray  # q (n_speed, n_channel), m
    mean: ComplexArray  # q + A f (n_speed, n_channel), m
    residual: ComplexArray  # r (n_speed, n_channel), in units of the noise
    change: ComplexArray  # ∂(q + A f)/∂u at this f (n_speed, n_channel, d), m

    @property
    def shown(self) -> Mask:
        """Which unknowns (d,) still show in the data once f is eliminated."""
        return np.asarray(np.any(self.whitened, axis=0))

    @property
    def n_searched(self) -> int:
        """How many do, but for as many as have a prior."""
        return int(np.count_nonzero(self.shown)) - (len(self.whitened) - 2 * self.residual.size)

    @property
    def n_left(self) -> int:
        """Real data that neither f nor these unknowns take."""
        n_speed, n_channel, n_free = self.columns.shape
        return int(2 * n_speed * (n_channel - n_free)) - self.n_searched

    @property
    def excess(self) -> float:
        """Mean square of the residuals, in units of the noise."""
        return self.deviance / self.n_left


class SumOfSquares(ABC):
    """χ² of residuals that a model leaves, for `ksmea.inference.maximisation`."""

    least_gain = 0.0

    @property
    def linearises_at_once(self) -> bool:
        return False

    @abstractmethod
    def _residual(self, theta: Array) -> Array:
        """Residuals at points (n, p), as real numbers of unit variance (n, m)."""

    def deviance(self, theta: Array) -> float:
        try:
            [residual] = self._residual(theta[None])
        except np.linalg.LinAlgError:
            return np.inf
        return float(residual @ residual)

    def other_noise(self, theta: Array) -> list[Array]:
        """None: the noise is held."""
        return []

    def curvature(self, point: Point, step: Array) -> Array:
        start, end = self._residual(np.stack([point.theta, point.theta + BEND * step]))
        return np.asarray(2 / BEND * ((end - start) / BEND - point.whitened @ step))


class ProjectedLikelihood(SumOfSquares):
    """χ² of r as a function of the unknowns in the unit cube, the noise s (n_speed, n_channel) being held.

    `ksmea.inference.maximisation` maximises it like a likelihood.
    """

    def __init__(self, case: Case, unmodelled: Unmodelled, sd: Array) -> None:
        problem = case.problem
        self.case = case
        self.problem = problem
        self.measurement = case.measurement
        self.measured: ComplexArray = np.asarray(case.measurement.values, dtype=complex)
        self.unmodelled = unmodelled
        self.sd = sd
        self.d = len(problem.parameters)
        self.lower = np.zeros(self.d)
        self.upper = np.ones(self.d)
        self.period = problem.parameters.period
        self.longest_step = np.full(self.d, np.inf)

    @property
    def linearises_at_once(self) -> bool:
        return self.problem.linearises_cheaply(self.unmodelled.loads)

    def with_sd(self, sd: Array) -> ProjectedLikelihood:
        """This likelihood with other noise (n_speed, n_channel), m."""
        return ProjectedLikelihood(self.case, self.unmodelled, sd)

    def at(self, theta: Array) -> ProjectedPoint:
        parameters = self.problem.parameters
        both, slopes = self.unmodelled.linearised(self.problem, parameters.to_si(theta))
        response, columns = both[..., 0], both[..., 1:]
        misfit, whitened = self._whitened(response), columns / self.sd[..., None]
        basis = orthonormal(whitened)
        free = -solved(basis, whitened, misfit)
        change = (slopes[:, :, 0] + np.einsum("sckd,sk->scd", slopes[:, :, 1:], free)) * parameters.width
        residual = without(basis, misfit[..., None])[..., 0]
        jacobian = without(basis, change / self.sd[..., None])  # (n_speed, n_channel, d)
        kept = _size(jacobian) > LEAST_KEPT * _size(change / self.sd[..., None])
        rows = self._real(np.where(kept, jacobian, 0.0).reshape(-1, len(theta)))
        rows = with_prior_rows(rows, parameters)
        real = np.concatenate([self._real(residual.ravel()), self.problem.parameters.off_priors(theta)])
        return ProjectedPoint(
            theta,
            float(real @ real),
            2 * rows.T @ real,
            rows,
            free,
            basis,
            columns,
            response,
            response + (columns @ free[..., None])[..., 0],
            residual,
            change,
        )

    def _residual(self, theta: Array) -> Array:
        """r at points (n, d) as real numbers of unit variance (n, m)."""
        response, columns = self._model(theta)
        basis = orthonormal(columns / self.sd[..., None])
        left = without(basis, self._whitened(response)[..., None])
        real = self._real(left.reshape(len(theta), -1), axis=1)
        return np.concatenate([real, self.problem.parameters.off_priors(theta)], axis=1)

    def _model(self, theta: Array) -> tuple[ComplexArray, ComplexArray]:
        """q and A at points (n, d) of the unit cube."""
        x = self.problem.parameters.to_si(theta)
        return self.unmodelled.response_and_columns(self.problem, x)

    def _whitened(self, response: ComplexArray) -> ComplexArray:
        return np.asarray((response - self.measured) / self.sd)

    def _real(self, values: ComplexArray, axis: int = 0) -> Array:
        return self.measurement.kind.real_parts(values, axis=axis)


@dataclass(frozen=True)
class SiteFit:
    """The model with something unknown, fitted."""

    likelihood: ProjectedLikelihood
    point: ProjectedPoint

    @property
    def unmodelled(self) -> Unmodelled:
        return self.likelihood.unmodelled


def inputs_held(fit: SiteFit) -> SiteFit:
    """A fit with numbers known to a tolerance held where they are; itself if all are exact."""
    base, parameters = fit.likelihood, fit.likelihood.problem.parameters
    if len(parameters.own) == len(parameters):
        return fit
    held = HeldProblem(base.problem, parameters.own, parameters.to_si(fit.point.theta))
    likelihood = ProjectedLikelihood(base.case.by(held), base.unmodelled, base.sd)
    return SiteFit(likelihood, likelihood.at(fit.point.theta[parameters.own]))


def all_values(fit: SiteFit) -> Array:
    """Values (d,) SI of all unknowns of a fit, including the held ones."""
    problem = fit.likelihood.problem
    x = problem.parameters.to_si(fit.point.theta)
    return problem.whole(x) if isinstance(problem, HeldProblem) else x


def orthonormal(columns: ComplexArray) -> ComplexArray:
    """An orthonormal basis (…, n_channel, k) of what columns (…, n_channel, k) span, by Gram and Schmidt."""
    basis = np.array(columns, dtype=complex)
    for index in range(basis.shape[-1]):
        column = without(basis[..., :index], basis[..., index, None])[..., 0]
        basis[..., index] = column / np.linalg.norm(column, axis=-1, keepdims=True)
    return basis


def without(basis: ComplexArray, columns: ComplexArray) -> ComplexArray:
    """Part of columns (…, n_channel, m) orthogonal to an orthonormal basis (…, n_channel, k)."""
    return np.asarray(columns - basis @ (np.conj(np.swapaxes(basis, -1, -2)) @ columns))


def solved(basis: ComplexArray, columns: ComplexArray, values: ComplexArray) -> ComplexArray:
    """A⁺ values (…, k) of columns A (…, n_channel, k) with their orthonormal basis."""
    adjoint = np.conj(np.swapaxes(basis, -1, -2))
    return np.asarray(np.linalg.solve(adjoint @ columns, adjoint @ values[..., None])[..., 0])


def _size(columns: ComplexArray) -> Array:
    """Norms (d,) of columns (n_speed, n_channel, d)."""
    return np.asarray(np.sqrt(np.sum(np.abs(columns) ** 2, axis=(0, 1))))
