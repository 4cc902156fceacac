"""The response of a linear rotor as the rational function of the bearing impedances that it is.

At each speed every response per unbalance is N(z) / Q(z) (`ksmea.problem.response_structure`), polynomials of a known degree in each
unknown impedance z = k + iΩc. A few samples determine their coefficients, and the surrogate is exact but for rounding:
13 for the three-disk rotor, whose N and Q have 9 terms each, (3 · 9 − 1) / 2 complex unknowns for each of two channels.

Samples beyond these are left out in turn and predicted. If the largest relative error of these predictions is above
`tolerance`, the response is not rational in the impedances: of a nonlinear rotor, of other unknowns, or of samples that
carry noise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.observable import Observable
from ksmea.plugins.surrogate import Predictor, Surrogate, Unsuited
from ksmea.plugins.transforms import Transform
from ksmea.problem.response_structure import ResponseStructure
from ksmea.settings.settings import setting
from surrogates.kriging import Kriging
from surrogates.none import NoSurrogate
from surrogates.rational_fit import Terms, evaluate, fit_coefficients, least_samples, left_out_predictions

SUBSTITUTES = {"kriging": Kriging, "none": NoSurrogate}
STOP = "stop"
INSTEAD = {"kriging": "Kriging takes over", "none": "the true model takes over", STOP: "take surrogate=kriging"}
LEAST_RELATIVE = 1e-3  # of the typical response: errors of smaller ones are taken relative to that


@dataclass(frozen=True)
class Rational(Surrogate):
    """Settings of the rational surrogate of a linear rotor, exact from few samples (`docs/rational.md`).

    It needs the problem's impedances (`with_structure`); samples alone, without a problem, are fitted by its
    substitute.

    Its outputs are complex responses, whatever is measured.
    """

    transform = "complex"

    fallback: str = setting(
        "kriging",
        "what takes over where left-out samples show that the response is not rational: another surrogate, the true model"
        " (none), or an error (stop)",
        choices=(*SUBSTITUTES, STOP),
    )
    tolerance: float = setting(
        1e-4,
        "largest relative error of a left-out response that counts as exact; rounding left at most 1.2e-6 in 100 designs",
        above=0,
    )

    @property
    def substitute(self) -> Surrogate | None:
        return None if self.fallback == STOP else SUBSTITUTES[self.fallback]()

    def with_structure(self, structure: ResponseStructure) -> Surrogate:
        if not structure.impedances:
            raise SettingError(
                "surrogate=rational: expected a problem that names its `unknown_impedances` and has no effects or"
                " runs, got none; take surrogate=kriging"
            )
        return StructuredRational(self, structure)

    def least_samples(self, d: int) -> int:
        return self._required_substitute().least_samples(d)

    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        return self._required_substitute().fit(u, y, rng)

    def _required_substitute(self) -> Surrogate:
        if (substitute := self.substitute) is None:
            raise SettingError("surrogate=rational: expected the impedances (`with_structure`), got samples alone")
        return substitute


@dataclass(frozen=True)
class StructuredRational(Surrogate):
    """The rational surrogate of one problem's response."""

    transform = "complex"

    settings: Rational
    structure: ResponseStructure

    def least_samples(self, d: int) -> int:
        """Number of coefficients, and at least the samples of the substitute; none remains to be left out."""
        substitute = self.settings.substitute
        return max(self._least, 0 if substitute is None else substitute.least_samples(d))

    @property
    def _least(self) -> int:
        return least_samples(self._terms.count, self.structure.n_channel, self.structure.n_load)

    @property
    def _terms(self) -> Terms:
        limits = np.stack([self.structure.parameters.lower, self.structure.parameters.upper])
        low, high = self.structure.impedance(limits).transpose(1, 0, 2)
        return Terms(low, high, [item.n_port for item in self.structure.impedances])

    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> RationalPredictor:
        """Samples u (n, d), real and imaginary parts y (n, q); random numbers are not used."""
        if len(u) < self._least:
            raise SettingError(f"surrogate=rational: expected {self._least} samples or more, got {len(u)}; take more")
        structure, terms = self.structure, self._terms
        outputs = Transform("complex", Observable.COMPLEX, len(structure.speed), structure.n_channel)
        response = np.asarray(outputs.decode(y), dtype=complex)
        x = structure.parameters.to_si(u)
        at_samples, loads = terms.at(structure.impedance(x)), structure.loads(x)
        predicted = left_out_predictions(at_samples, loads, response, self._least)
        error = None if predicted is None else np.abs(predicted - response)
        if error is not None and not (largest := _largest_relative(error, response)) <= self.settings.tolerance:
            raise self._unsuited(largest)
        coefficients = fit_coefficients(at_samples, loads, response)
        return RationalPredictor(structure, terms, outputs, coefficients, error, response)

    def _unsuited(self, largest: float) -> Unsuited:
        """The error for a largest relative error of left-out responses."""
        items, fallback = self.structure.impedances, self.settings.fallback
        names = dict.fromkeys(name for item in items for name in (item.stiffness, item.damping, item.mass) if name)
        return Unsuited(
            f"surrogate=rational: expected a response that is a rational function of {', '.join(names)}, got one that left-out"
            f" samples show to be off by {100 * largest:.2g} % (tolerance {100 * self.settings.tolerance:g} %)"
            f"; {INSTEAD[fallback]}",
            self.settings.substitute,
        )


@dataclass(frozen=True, eq=False)
class RationalPredictor(Predictor):
    """N(z) / Q(z) at each speed, times the loads."""

    structure: ResponseStructure
    terms: Terms
    outputs: Transform
    coefficients: ComplexArray  # (n_speed, n_term, n_channel n_load + 1)
    error: Array | None  # (n, n_speed, n_channel) m, of samples that were left out
    response: ComplexArray  # (n, n_speed, n_channel) m, at the samples

    def predict(self, u: Array) -> Array:
        """Points (k, d) → real and imaginary parts (k, q)."""
        x = self.structure.parameters.to_si(u)
        terms = self.terms.at(self.structure.impedance(x))
        return self.outputs.encode(evaluate(self.coefficients, terms, self.structure.loads(x)))

    def leave_one_out(self) -> Array | None:
        """Root mean square error of each output (q,).

        Half of each response's error is in its real and half in its imaginary part.
        """
        if self.error is None:
            return None
        each = np.sqrt(np.mean(self.error**2, axis=0) / 2).ravel()
        return np.concatenate([each, each])

    @property
    def notes(self) -> Mapping[str, float]:
        """The largest relative error of a left-out response, where samples were left out."""
        return {} if self.error is None else {"left_out_error": _largest_relative(self.error, self.response)}


def _largest_relative(error: Array, response: ComplexArray) -> float:
    """Largest relative error of samples (n, n_speed, n_channel); NaN if one of them is."""
    size = np.abs(response)
    return float(np.max(error / np.maximum(size, LEAST_RELATIVE * np.median(size, axis=0))))
