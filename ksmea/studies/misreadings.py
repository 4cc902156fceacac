"""A remark where data fit the model far better if they are read in another way (`ksmea.studies.readings`).

Where the fit is bad, the model is fitted to each reading, cheaply and with the noise estimated along. The deviances of
readings can be compared as they are: to conjugate, to turn by 180° and to swap leave every |y| as it is, and other speeds
change the model alone. A factor c on n real data changes their density by its Jacobian, ln L(y) = ln L(c y) + n ln c: with
the noise unknown the deviance is relative to s₀ = |y| and has that term already.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

import numpy as np

from ksmea.alignment import aligned
from ksmea.arrays import Array, ComplexArray
from ksmea.contracts import Problem
from ksmea.diagnosis.fitting import Fit
from ksmea.diagnosis.screening import screened
from ksmea.difference_likelihood import likelihood_of
from ksmea.errors import SettingError
from ksmea.harmonics import at_1x
from ksmea.likelihood import Likelihood
from ksmea.maximisation import MAX_ITERATIONS, maximise
from ksmea.measurement import Measurement, Noise
from ksmea.model import Model
from ksmea.point import Point
from ksmea.screening import sobol
from ksmea.studies.readings import Reading, double_readings, readings

PLAUSIBLE = 0.3  # noise beside the response, in the median: usable probes have less
NOISE_RATIO = 0.5  # a remark is made of readings that leave at most this part of the noise …
DECISIVE = 50.0  # … and a deviance lower by this: by chance the best of thirty readings is lower by 2 ln 30 = 7
NEAR = 6.0  # deviance within which readings cannot be told apart
MOST = 1000  # per cent; more noise is only said to be more

# Of the fit of each reading: points screened, starts and their distance in the unit cube, iterations from each and from the
# best; then how many readings are fitted to the end.
SCREENING, STARTS, START_DISTANCE, FIRST_ITERATIONS, ITERATIONS, SURVIVORS = 1024, 4, 0.1, 6, 15, 4
TOLERANCE = 1e-2  # of a deviance


def misreadings(
    problem: Problem, measurement: Measurement, x: Array, noise: Noise | None, *, rejected: bool
) -> tuple[str, ...]:
    """A remark on the readings that fit best, or nothing; `x` (d,) SI and `noise` are those of the fit, which is bad where
    the lack-of-fit test `rejected` it or the noise, if estimated, is implausibly large.

    Nothing is said where many fits in passing may take long: of a problem without a sensitivity, or with unknowns that are
    costly to change.
    """
    if noise is None or noise.is_absent or not problem.has_sensitivity or len(problem.costly):
        return ()
    problem, measurement = at_1x(problem, measurement)
    too_noisy = measurement.noise is None and _share(noise, problem.response(x[None])[0]) > PLAUSIBLE
    if not (rejected or too_noisy):
        return ()
    data = dataclasses.replace(measurement, noise=None)
    likelihood = likelihood_of(Model(problem), data)
    start = likelihood.start(np.clip(problem.parameters.to_cube(x), 0.0, 1.0))
    as_read = Fit(problem, likelihood, _climbed(likelihood, start))
    again = _fit(problem, data)
    if again is not None and again.deviance < as_read.deviance:
        as_read = _converged(again)
    for ways in (readings(data), double_readings(data)):
        if found := _better(problem, ways, as_read):
            return (_text(found, as_read),)
    return ()


def _better(problem: Problem, ways: Iterable[Reading], as_read: Fit) -> list[tuple[Reading, Fit]]:
    """The readings that fit decisively better and leave plausible noise, those that do so about as well as the best."""
    margin = max(DECISIVE, -2 * np.log(NOISE_RATIO) * as_read.likelihood.n_residual)
    first = [(reading, fit) for reading in ways if (fit := _fit(problem, reading.measurement)) is not None]
    first = sorted(first, key=lambda each: each[1].deviance)[:SURVIVORS]
    found = [(reading, _converged(fit)) for reading, fit in first if fit.deviance < as_read.deviance - NEAR]
    limit = min([as_read.deviance - margin, *(fit.deviance + NEAR for _, fit in found)])
    return [(reading, fit) for reading, fit in found if fit.deviance <= limit and _share_left(fit) <= PLAUSIBLE]


def _fit(problem: Problem, measurement: Measurement) -> Fit | None:
    """The problem fitted to data from a few starts, near its maximum if it has a good one; None where it cannot be."""
    try:
        problem = aligned(problem, measurement)
        likelihood = likelihood_of(Model(problem), measurement)
        points = sobol(SCREENING, likelihood.d) + 0.5 / SCREENING
        starts = screened(problem, measurement, points).apart(STARTS, START_DISTANCE).points
        first = [_climbed(likelihood, likelihood.start(u), FIRST_ITERATIONS) for u in starts]
        best = min(first, key=lambda point: point.deviance)
        return Fit(problem, likelihood, _climbed(likelihood, best.theta, ITERATIONS))
    except (SettingError, ArithmeticError, np.linalg.LinAlgError):
        return None


def _converged(fit: Fit) -> Fit:
    return Fit(fit.problem, fit.likelihood, _climbed(fit.likelihood, fit.point.theta))


def _climbed(likelihood: Likelihood, theta: Array, iterations: int = MAX_ITERATIONS) -> Point:
    return maximise(likelihood, theta, max_iterations=iterations, tolerance=TOLERANCE)


def _share(noise: Noise, response: ComplexArray) -> float:
    """The noise's standard deviation as a part of the response (n_speed, n_channel), in the median."""
    amplitude = np.abs(response)
    return float(np.median(noise.sd(amplitude) / amplitude))


def _share_left(fit: Fit) -> float:
    return _share(fit.noise, fit.response())


def _text(found: Sequence[tuple[Reading, Fit]], as_read: Fit) -> str:
    best = min((fit for _, fit in found), key=lambda fit: fit.deviance)
    given = _joined([reading.given for reading, _ in found])
    remedies = _joined([reading.remedies for reading, _ in found])
    return (
        f"the data look as if {given}: read so, the fit leaves {_per_cent(best)} noise instead of {_per_cent(as_read)}"
        f" (deviance {as_read.deviance - best.deviance:.0f} lower); {remedies}"
    )


def _joined(ways: Sequence[tuple[str, ...]]) -> str:
    """What all of them say, and what each says of its own."""
    common = [said for said in ways[0] if all(said in way for way in ways)]
    own = dict.fromkeys(said for way in ways for said in way if said not in common)
    return ", and ".join([*common, *(["; or ".join(own)] if own else [])])


def _per_cent(fit: Fit) -> str:
    share = 100 * _share_left(fit)
    return f"{share:.0f} %" if share < MOST else f"over {MOST} %"
