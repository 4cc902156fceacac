"""Laws that an unknown force may follow: from speed alone, or from the motion of its site.

A law has a few real coefficients c in place of two complex numbers at each speed: f = Σ c g(Ω), or f = −K q with
K = Σ c K(Ω) and q the motion of the site, which the force moves along:

    q = Q + G f,   f = −(1 + K G)⁻¹ K Q,

with Q the motion without it and G that per unit of it. Coefficients and the model's unknowns are fitted together. Nothing is
nearer to the data than the free force, so that what a law leaves beyond that is a test of it, with as many degrees of
freedom as it has fewer numbers; laws, also at different sites, compare by BIC.

Sign convention: a real force is Re(f e^{iΩt}); a rotating vector is (1, −i) in (x, y).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from ksmea.arrays import Array, ComplexArray
from ksmea.channel import DIRECTIONS, Channel
from ksmea.deviance import log_term
from ksmea.diagnosis.location import SiteFit, refitted
from ksmea.diagnosis.recovered_force import own_noise, recovered_force
from ksmea.diagnosis.unknown_force import SumOfSquares
from ksmea.differences import central_differences
from ksmea.likelihood import Point
from ksmea.maximisation import maximise
from ksmea.measurement import Noise
from ksmea.screening import sobol
from ksmea.units import GRAM_MILLIMETRE

STEP = 1e-5  # of differences: of the unit cube, and of the scale of each coefficient
SMALLEST = 1e-3  # of the largest coefficient: the scale of one that is next to nothing
N_OTHER = 8  # values of each unknown that the data do not show, a power of two
TOLERANCE = 1e-3  # of χ²
REWEIGHTINGS = 2  # after which weights from the response of a law stay as they are
N_WEIGHT = 50  # draws that weights are made of
FORWARD = np.array([1, -1j])
AXES = np.stack([np.diag([1.0, 0.0]), np.diag([0.0, 1.0])])
CROSS = np.array([[[0.0, 1.0], [-1.0, 0.0]]])


@dataclass(frozen=True)
class Law:
    """A law by name; `coefficients` have a name, a unit and its size in SI. `terms` at speeds (n_speed,): what acts per unit
    of each, (n_coefficient, n_speed, 2) N, or where it follows the motion the stiffness, (n_coefficient, n_speed, 2, 2) N/m."""

    name: str
    coefficients: tuple[tuple[str, str, float], ...]
    terms: Callable[[Array], ComplexArray]
    follows_motion: bool


def _rotating(power: int) -> Callable[[Array], ComplexArray]:
    """A vector fixed in the rotor, with its parts at angle 0 and a quarter turn on, that grows with a power of speed."""
    return lambda speed: np.array([1, 1j])[:, None, None] * speed[:, None] ** power * FORWARD


def _stiffness(matrices: Array, factor: complex, power: int) -> Callable[[Array], ComplexArray]:
    return lambda speed: matrices[:, None] * (factor * speed**power)[:, None, None]


def _pair(name: str, unit: str, size: float) -> tuple[tuple[str, str, float], ...]:
    return tuple((f"{name}_{axis}", unit, size) for axis in DIRECTIONS)


def _together(*parts: Callable[[Array], ComplexArray]) -> Callable[[Array], ComplexArray]:
    return lambda speed: np.concatenate([part(speed) for part in parts])


SPRING, OF_SPRING = _pair("k", "MN/m", 1e6), _stiffness(AXES, 1, 0)
DAMPER, OF_DAMPER = _pair("c", "kN s/m", 1e3), _stiffness(AXES, 1j, 1)
MASS, OF_MASS = (("m", "kg", 1.0),), _stiffness(np.eye(2)[None], -1, 2)

LAWS = (
    Law("constant, turning with the shaft", _pair("f", "N", 1.0), _rotating(0), False),
    Law("∝ Ω, turning with the shaft", _pair("f/Ω", "N s/rad", 1.0), _rotating(1), False),
    Law("unbalance, ∝ Ω²", _pair("u", "g mm", GRAM_MILLIMETRE), _rotating(2), False),
    Law("spring", SPRING, OF_SPRING, True),
    Law("damper", DAMPER, OF_DAMPER, True),
    Law("mass", MASS, OF_MASS, True),
    Law("cross-coupling", (("k_xy", "MN/m", 1e6),), _stiffness(CROSS, 1, 0), True),
    Law("spring and damper", (*SPRING, *DAMPER), _together(OF_SPRING, OF_DAMPER), True),
    Law("spring, damper and mass", (*SPRING, *DAMPER, *MASS), _together(OF_SPRING, OF_DAMPER, OF_MASS), True),
)


@dataclass(frozen=True)
class LawFit:
    """A law fitted at a site together with the unknowns: `p` of leaving no more than the free force, `bic` for comparison
    with other laws and sites, coefficients (n_coefficient,) SI with standard deviations."""

    law: Law
    site: SiteFit
    p: float
    bic: float
    values: Array
    sd: Array
    force: ComplexArray  # as the law has it (n_speed, 2) N


class LawLikelihood(SumOfSquares):
    """χ² of a model with a law at a site, of unknowns in the unit cube and, behind them, of coefficients in units of `scale`:
    what `ksmea.maximisation` can maximise."""

    def __init__(self, site: SiteFit, law: Law, scale: Array) -> None:
        base = site.likelihood
        problem, position = base.problem, site.unmodelled.position
        self.d = base.d
        self.law, self.scale = law, scale
        self.lower = np.concatenate([base.lower, np.full(len(scale), -np.inf)])
        self.upper = np.concatenate([base.upper, np.full(len(scale), np.inf)])
        self.period = np.concatenate([base.period, np.full(len(scale), np.inf)])
        self.longest_step = np.full(len(self.lower), np.inf)
        self._base, self._unmodelled = base, site.unmodelled
        self._terms = law.terms(problem.speed)
        at_site = [Channel(position, axis) for axis in DIRECTIONS] if law.follows_motion else []
        self._seen = problem.at(problem.speed, [*problem.channels, *at_site]) if at_site else problem

    def at(self, theta: Array) -> Point:
        differences = central_differences(theta, STEP, self.lower, self.upper)
        residual, *around = self._residual(np.concatenate([theta[None], differences.points]))
        jacobian = differences.derivative(np.array(around))
        return Point(theta, float(residual @ residual), 2 * jacobian.T @ residual, jacobian)

    def _residual(self, theta: Array) -> Array:
        """What is left at points (n, p), as real numbers of unit variance (n, m)."""
        left = (self.mean_and_force(theta)[0] - self._base.measured) / self._base.sd
        return self._base.measurement.kind.real_parts(left.reshape(len(theta), -1), axis=1)

    def mean_and_force(self, theta: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response (n, n_speed, n_channel), m, and what acts, (n, n_speed, 2) N, at points (n, p)."""
        x = self._base.problem.parameters.to_si(theta[:, : self.d])
        response, columns = self._seen.response(x), self._unmodelled.columns(self._seen, x)
        n_channel = len(self._base.problem.channels)
        force = np.einsum("nc,c...->n...", theta[:, self.d :] * self.scale, self._terms)
        if self.law.follows_motion:  # a stiffness until here
            motion, per_force = response[:, :, n_channel:, None], columns[:, :, n_channel:]
            force = -np.linalg.solve(np.eye(len(DIRECTIONS)) + force @ per_force, force @ motion)[..., 0]
        return response[:, :, :n_channel] + (columns[:, :, :n_channel] @ force[..., None])[..., 0], force


def fitted_laws(sites: Sequence[SiteFit], noise: Noise) -> list[LawFit]:
    """Every law at each site of an unknown force, the lowest BIC first; `noise` is that of the location."""
    fits = [fitted_law(site, law, noise) for site in sites for law in LAWS]
    return sorted(fits, key=lambda fit: fit.bic)


def fitted_law(site: SiteFit, law: Law, noise: Noise) -> LawFit:
    """A law at a site, from where it comes nearest to the free force. The weights come from its own response, for the free
    force that it is compared with too: a free force takes noise along, and with it weights that favour small values."""
    starts = [(each.point.theta, _nearest(each, law)) for each in (site, *_others(site))]
    largest = np.max(np.abs([coefficients for _, coefficients in starts]), axis=0)
    scale = np.maximum(largest, SMALLEST * largest.max())
    likelihood = LawLikelihood(site, law, scale)
    tried = [maximise(likelihood, np.concatenate([u, each / scale]), tolerance=TOLERANCE) for u, each in starts]
    found = min(tried, key=lambda point: point.deviance)
    for _ in range(REWEIGHTINGS):
        response, _ = likelihood.mean_and_force(found.theta[None])
        site = refitted(site, noise.sd(np.abs(response[0])))
        likelihood = LawLikelihood(site, law, scale)
        found = maximise(likelihood, found.theta, tolerance=TOLERANCE)
    free, n_coefficient = site.point, len(scale)
    n_more = 2 * free.free.size - n_coefficient - (likelihood.d - free.n_searched)
    beyond, excess = max(found.deviance - free.deviance, 0.0), own_noise(site) ** 2
    measurement, sd = site.likelihood.measurement, site.likelihood.sd
    is_known = measurement.noise is not None
    p = stats.chi2.sf(beyond, n_more) if is_known else stats.f.sf(beyond / n_more / excess, n_more, free.n_left)
    # weights differ from law to law: the whole deviance is compared
    sizes = log_term(sd**2, noise.variance(np.abs(measurement.values)), measurement.kind)
    covariance = excess * np.linalg.pinv(found.information)
    return LawFit(
        law,
        site,
        p=float(p),
        bic=float(found.deviance + np.sum(sizes) + n_coefficient * np.log(found.whitened.shape[0])),
        values=found.theta[likelihood.d :] * scale,
        sd=np.sqrt(np.diag(covariance)[likelihood.d :]) * scale,
        force=likelihood.mean_and_force(found.theta[None])[1][0],
    )


def _others(site: SiteFit) -> list[SiteFit]:
    """The fit with other values of unknowns that the data do not show beside a free force, but may beside a law."""
    hidden = ~np.any(site.point.whitened, axis=0)
    if not np.any(hidden):
        return []
    found = []
    for values in sobol(N_OTHER, int(hidden.sum())) + 0.5 / N_OTHER:
        theta = site.point.theta.copy()
        theta[hidden] = values
        found.append(SiteFit(site.likelihood, site.likelihood.at(theta)))
    return found


def _nearest(site: SiteFit, law: Law) -> Array:
    """The coefficients that come nearest to the free force, each speed weighed as it is known."""
    found = recovered_force(site, np.random.default_rng(0), n_draw=N_WEIGHT)
    spread = np.std(found.force[1:], axis=0)
    terms = law.terms(site.likelihood.problem.speed)
    if law.follows_motion and found.motion is not None:
        terms = -(terms @ found.motion[0][..., None])[..., 0]
    columns = (terms / spread).reshape(len(terms), -1)
    target = (found.force[0] / spread).ravel()
    real = [np.concatenate([each.real, each.imag], axis=-1) for each in (columns, target)]
    return np.asarray(np.linalg.lstsq(real[0].T, real[1])[0])
