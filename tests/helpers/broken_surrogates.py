"""A surrogate that keeps every property of its exam, and for each property one that breaks it."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import NearestNDInterpolator, RBFInterpolator

from ksmea import Predictor, Surrogate


class Interpolated(Predictor):
    """Cubic radial basis functions with a linear trend."""

    def __init__(self, u, y, at=lambda predicted: predicted, error=None, **options):
        self.u, self.y, self.at, self.error = u, y, at, error
        self.function = RBFInterpolator(u, y, kernel="cubic", **options)

    def predict(self, u):
        return self.at(self.function(u))

    def leave_one_out(self):
        return self.error


@dataclass(frozen=True)
class Radial(Surrogate):
    """Radial basis functions."""

    def least_samples(self, d):
        return d + 1

    def fit(self, u, y, rng):
        return Interpolated(u, y)


@dataclass(frozen=True)
class Transposed(Radial):
    """A column for each point."""

    def fit(self, u, y, rng):
        return Interpolated(u, y, at=np.transpose)


@dataclass(frozen=True)
class OneError(Radial):
    """One error for all outputs."""

    def fit(self, u, y, rng):
        return Interpolated(u, y, error=np.float64(0.1))


@dataclass(frozen=True)
class Smooth(Radial):
    """It smooths, and does not say so."""

    def fit(self, u, y, rng):
        return Interpolated(u, y, smoothing=1.0)


@dataclass(frozen=True)
class Nearest(Radial):
    """It takes the value of the nearest sample."""

    def fit(self, u, y, rng):
        found = Interpolated(u, y)
        found.function = NearestNDInterpolator(u, y)
        return found


@dataclass(frozen=True)
class LastLast(Radial):
    """Its first sample counts apart."""

    def fit(self, u, y, rng):
        return Interpolated(u, y, at=lambda predicted: predicted + 0.1 * (y[0] - y[-1]))


@dataclass(frozen=True)
class InMetres(Radial):
    """It draws outputs to 0, wherever that is in their unit."""

    def fit(self, u, y, rng):
        return Interpolated(u, y, at=lambda predicted: 0.99 * predicted)


@dataclass(frozen=True)
class Hungry(Radial):
    """It needs more samples than it says."""

    def fit(self, u, y, rng):
        if len(u) < 50:
            raise ValueError("too few samples")
        return Interpolated(u, y)


class NeverGrows(Interpolated):
    """It takes a sample and leaves it out."""

    def append(self, u, y):
        return self


@dataclass(frozen=True)
class Forgets(Radial):
    """Its predictor never grows."""

    def fit(self, u, y, rng):
        return NeverGrows(u, y)


@dataclass(frozen=True)
class FittedTruth(Radial):
    """It says that it is the true model, and can be fitted."""

    is_true_model = True


BROKEN_SURROGATES = [
    ("predicts_in_shape", Transposed(), r"predictions of shape \(7, 24\), got \(24, 7\); return a row for each point"),
    ("tells_its_error_in_shape", OneError(), r"24 errors, none below 0, got .*0.1.*; take the root of the mean square"),
    ("follows_its_samples", Smooth(), r"at most 0.001 standard deviations at the samples, got .*at_samples=…"),
    ("predicts_between_its_samples", Nearest(), r"at most 0.3 standard deviations between 60 samples, got .*between=…"),
    ("order_of_samples_is_none", LastLast(), r"the same predictions, got others by .*; treat all samples alike"),
    (
        "units_of_outputs_do_not_matter",
        InMetres(),
        r"in micrometres, got another by .*; standardise the outputs inside",
    ),
    (
        "few_samples_are_enough",
        Hungry(),
        r"the smallest number of samples that it states can be fitted, got ValueError: too few",
    ),
    ("grows_by_a_sample", Forgets(), r"at all samples after append, got .*; let append use the new sample"),
    ("is_never_fitted", FittedTruth(), r"a TypeError of fit, got a predictor; raise it, or set is_true_model = False"),
]
