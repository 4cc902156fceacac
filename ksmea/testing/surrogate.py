"""The exam of surrogates, on the response of a Jeffcott rotor.

Shapes, samples, their order and their units.

Outputs are made of the response by the surrogate's own transform and turned back, as a method does it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.observable import Observable
from ksmea.numerics.screening import latin_hypercube
from ksmea.plugins.surrogate import Predictor, Surrogate
from ksmea.plugins.transforms import Transform, make_transform
from ksmea.testing.exam import Exam, ExamFailed, require
from ksmea.testing.jeffcott import Jeffcott
from ksmea.testing.repeat import OF_DRAWS, Drawn
from ksmea.testing.settings import OF_SETTINGS
from ksmea.testing.surroundings import IN_A_SWEEP

ROTOR = Jeffcott(speed=np.linspace(100.0, 500.0, 4))
DIM = len(ROTOR.parameters)
N_NEW = 7  # points besides the samples
MICROMETRES = 1e6  # a metre
# Of the outputs' standard deviation: an estimate of a surrogate's own parameters ends elsewhere by rounding, and stays flat there.
SAME = 1e-3


@dataclass(frozen=True)
class SurrogateCase(Drawn):
    """A surrogate, and what is stated of it.

    With `samples` of five unknowns its rms error, in parts of the standard deviation of each output, is at most
    `at_samples` at the samples and `between` elsewhere. `at_samples` of one that smooths is larger than of one that
    interpolates.
    """

    contract: ClassVar = Surrogate
    plugin: Surrogate
    samples: int = 60
    at_samples: float = 1e-3
    between: float = 0.3

    @property
    def transform(self) -> Transform:
        return make_transform(
            self.plugin.transform, Observable.COMPLEX, n_speed=len(ROTOR.speed), n_channel=len(ROTOR.channels)
        )

    @cached_property
    def points(self) -> Array:
        return latin_hypercube(self.samples, DIM, np.random.default_rng(1))

    @cached_property
    def outputs(self) -> Array:
        return self.outputs_at(self.points)

    @cached_property
    def new(self) -> Array:
        """Points (N_NEW, d) that are no samples, away from the edges."""
        return 0.1 + 0.8 * latin_hypercube(N_NEW, DIM, np.random.default_rng(2))

    def outputs_at(self, u: Array, metre: float = 1.0) -> Array:
        return self.transform.encode(metre * ROTOR.response(ROTOR.parameters.to_si(u)))

    @cached_property
    def fitted(self) -> Predictor:
        return self.fit(self.points, self.outputs)

    def fit(self, u: Array, y: Array, seed: int = 1) -> Predictor:
        """A fit to samples that cannot be written into."""
        u, y = u.copy(), y.copy()
        u.flags.writeable = y.flags.writeable = False
        return self.plugin.fit(u, y, np.random.default_rng(seed))

    def outcome(self, seed: int) -> Array:
        return self.fit(self.points, self.outputs, seed).predict(self.new)

    def error(self, found: Array, expected: Array) -> float:
        """Largest rms difference of an output over its standard deviation among the samples."""
        return float(np.max(np.sqrt(np.mean((found - expected) ** 2, axis=0)) / self.outputs.std(axis=0)))


def predicts_in_shape(case: SurrogateCase) -> None:
    """Points (k, d) give finite predictions (k, q), each as it is alone.

    Variances likewise, and no less than 0.
    """
    n, q = len(case.new), case.outputs.shape[1]
    found = case.fitted.predict(case.new)
    require(found.shape == (n, q), f"predictions of shape {(n, q)}", found.shape, "return a row for each point")
    require(np.all(np.isfinite(found)), "finite predictions", "NaN or infinity", "look at the fit of smooth outputs")
    alone = np.concatenate([case.fitted.predict(u[None]) for u in case.new])
    require(
        case.error(alone, found) < SAME, "a point predicted alone as in a batch", "another value", "treat rows apart"
    )
    variance = case.fitted.variance(case.new)
    require(
        variance is None or (variance.shape == (n, q) and np.all(variance >= 0)),
        f"variances {(n, q)}, none below 0, or None",
        f"shape {variance.shape}, least {np.min(variance):.3g}" if variance is not None else "",
        "cut rounding off at 0",
    )


def tells_its_error_in_shape(case: SurrogateCase) -> None:
    """Leave-one-out errors are one number for each output, none below 0.

    They may also be None, and the prediction counts as exact.
    """
    q, errors = case.outputs.shape[1], case.fitted.leave_one_out()
    if errors is not None:
        right = errors.shape == (q,) and bool(np.all(errors >= 0))
        require(
            right, f"{q} errors, none below 0", f"{errors!r:.60}", "take the root of the mean square of each output"
        )


def follows_its_samples(case: SurrogateCase) -> None:
    """At the samples it is as near as stated: at them if it interpolates, next to them if it smooths."""
    error = case.error(case.fitted.predict(case.points), case.outputs)
    require(
        error <= case.at_samples,
        f"an rms error of at most {case.at_samples:g} standard deviations at the samples",
        f"{error:.3g}",
        "mend the fit, or state how much it smooths: at_samples=…",
    )


def predicts_between_its_samples(case: SurrogateCase) -> None:
    """Between the samples it is as near as stated; the mean of the samples would be at 1."""
    error = case.error(case.fitted.predict(case.new), case.outputs_at(case.new))
    require(
        error <= case.between,
        f"an rms error of at most {case.between:g} standard deviations between {case.samples} samples",
        f"{error:.3g}",
        "mend the fit, or state what it reaches: samples=…, between=…",
    )


def order_of_samples_is_none(case: SurrogateCase) -> None:
    """Samples in another order give the same predictions."""
    order = np.random.default_rng(3).permutation(case.samples)
    found = case.fit(case.points[order], case.outputs[order]).predict(case.new)
    error = case.error(found, case.fitted.predict(case.new))
    require(
        error < SAME, "the same predictions", f"others by {error:.3g} standard deviations", "treat all samples alike"
    )


def units_of_outputs_do_not_matter(case: SurrogateCase) -> None:
    """A response in micrometres gives the predictions of one in metres, in micrometres."""
    found = case.fit(case.points, case.outputs_at(case.points, MICROMETRES)).predict(case.new)
    expected = case.transform.decode(case.fitted.predict(case.new))
    error = np.max(np.abs(case.transform.decode(found) / MICROMETRES - expected)) / np.std(np.abs(expected))
    require(
        error < SAME,
        "the same response in micrometres",
        f"another by {error:.3g} of its standard deviation",
        "standardise the outputs inside, so that no constant has their unit",
    )


def few_samples_are_enough(case: SurrogateCase) -> None:
    """The smallest number of samples that it states can be fitted."""
    n = case.plugin.least_samples(DIM)
    require(isinstance(n, int) and n >= 1, "a whole number of samples, at least 1", repr(n), "count its terms")
    u = latin_hypercube(n, DIM, np.random.default_rng(4))
    found = case.fit(u, case.outputs_at(u)).predict(case.new)
    require(np.all(np.isfinite(found)), f"finite predictions from {n} samples", "others", "increase least_samples")


def grows_by_a_sample(case: SurrogateCase) -> None:
    """With one more sample, appended or fitted again, it follows that too.

    The earlier predictor stays as it was.
    """
    earlier = case.fit(case.points[:-1], case.outputs[:-1])
    before = earlier.predict(case.new)
    refitted = case.plugin.refit(earlier, case.points, case.outputs, np.random.default_rng(1))
    for name, later in (("refit", refitted), ("append", earlier.append(case.points[-1], case.outputs[-1]))):
        if later is None:
            continue
        error = case.error(later.predict(case.points), case.outputs)
        require(
            error <= 2 * case.at_samples,  # θ and the like may stay those of fewer samples
            f"an rms error of at most {2 * case.at_samples:g} at all samples after {name}",
            f"{error:.3g}",
            f"let {name} use the new sample, or leave it out",
        )
    unchanged = np.array_equal(earlier.predict(case.new), before)
    require(
        unchanged, "the earlier predictor as it was", "other predictions", "return a new one, and copy what changes"
    )


def is_never_fitted(case: SurrogateCase) -> None:
    """A surrogate that is the true model rejects a fit."""
    try:
        case.fitted.predict(case.new)
    except TypeError:
        return
    raise ExamFailed("expected a TypeError of fit, got a predictor; raise it, or set is_true_model = False")


def surrogate_properties(case: SurrogateCase) -> Sequence[Callable[[SurrogateCase], None]]:
    if case.plugin.is_true_model:
        return (*OF_SETTINGS, is_never_fitted)
    return (
        *OF_SETTINGS,
        *IN_A_SWEEP,
        predicts_in_shape,
        tells_its_error_in_shape,
        follows_its_samples,
        predicts_between_its_samples,
        order_of_samples_is_none,
        units_of_outputs_do_not_matter,
        few_samples_are_enough,
        grows_by_a_sample,
        *OF_DRAWS,
    )


check_surrogate = Exam(SurrogateCase, surrogate_properties)
