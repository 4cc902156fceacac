"""Misread data (lag given as lead, probes swapped, other units): the reading that fits far better.

If the fit is bad, the model is fitted to each reading that could fit better, cheaply, the noise estimated; the best go on.
Deviances of readings can be compared as they are: to conjugate, to turn by 180° and to swap leave every |y| unchanged, and
other speeds change the model alone. A factor c on n real data changes their density by its Jacobian, ln L(y) = ln L(c y) +
n ln c: with the noise unknown the deviance is relative to s₀ = |y| and has that term already.

Another remark is made if no critical speed lies near the measured band. No data are rejected: odd machines exist.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.fits.fitting import Fit
from ksmea.fits.starts import screened
from ksmea.inference.maximisation import MAX_ITERATIONS, maximise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.channel import ANGLES, DIRECTIONS, direction_at, named
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.numerics.screening import sobol
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem
from ksmea.units import HERTZ, INCH, MICROMETRE, RPM

PLAUSIBLE = 0.3  # noise beside the response, in the median: usable probes have less
NOISE_RATIO = 0.5  # a remark is made of readings that leave at most this part of the noise …
DECISIVE = 50.0  # … and a deviance lower by this: by chance the best of thirty readings is lower by 2 ln 30 = 7
NEAR = 6.0  # deviance within which readings cannot be told apart
MOST = 1000  # per cent; more noise is only said to be more

# Of the fit of each reading: points screened, starts and their distance in the unit cube, iterations from each. The best readings
# take further iterations, and of these the best are fitted to the end.
SCREENING, STARTS, START_DISTANCE, FIRST_ITERATIONS = 1024, 4, 0.1, 6
CONTINUED, ITERATIONS, SURVIVORS = 8, 15, 4
TOLERANCE = 1e-2  # of a deviance
AT_LIMIT = 1e-3  # part of its range at which an unbalance is taken to lie on its limit


@dataclass(frozen=True)
class Misread:
    """Readings that fit about as well as the best one, each with its fit, and the data as read, fitted."""

    found: tuple[tuple[Reading, Fit], ...]
    as_read: Fit

    @property
    def best(self) -> tuple[Reading, Fit]:
        return min(self.found, key=_deviance)

    def __str__(self) -> str:
        return _text(self.found, self.as_read)


def misreadings(case: Case, x: Array, noise: Noise | None, *, rejected: bool) -> tuple[str, ...]:
    """A remark on the readings that fit best; empty if none does (`misread`)."""
    found = misread(case, x, noise, rejected=rejected)
    return () if found is None else (str(found),)


def misread(case: Case, x: Array, noise: Noise | None, *, rejected: bool) -> Misread | None:
    """The readings that fit decisively better; None unless the fit is bad.

    `x` (d,) SI and `noise` belong to the fit. It is bad if the lack-of-fit test `rejected` it or the noise, if
    estimated, is implausibly large.

    None also if the many fits may take long: for a problem without a sensitivity, or with unknowns that are costly to change.
    """
    if noise is None or noise.is_absent or not case.problem.has_sensitivity or len(case.problem.costly):
        return None
    case = case.at_1x()
    problem = case.problem
    too_noisy = case.measurement.noise is None and _share(noise, problem.response(x[None])[0]) > PLAUSIBLE
    if not (rejected or too_noisy):
        return None
    data = dataclasses.replace(case.measurement, noise=None)
    likelihood = likelihood_of(case.of_measurement(data))
    start = likelihood.start(np.clip(problem.parameters.to_cube(x), 0.0, 1.0))
    as_read = Fit(likelihood, _climbed(likelihood, start))
    again = _begun(problem, data)
    if again is not None and (again := _continued(again)).deviance < as_read.deviance:
        as_read = _continued(again, MAX_ITERATIONS)
    for ways in (readings(data), double_readings(data)):
        if found := _better(problem, ways, as_read):
            return Misread(tuple(found), as_read)
    return None


def _better(problem: Problem, ways: Iterable[Reading], as_read: Fit) -> list[tuple[Reading, Fit]]:
    """Readings that fit decisively better, leave plausible noise, and fit about as well as the best one."""
    margin = max(DECISIVE, -2 * np.log(NOISE_RATIO) * as_read.likelihood.n_residual)
    other = (reading for reading in ways if not _is_taken_by_unbalance(as_read, reading.factor))
    begun = [(reading, fit) for reading in other if (fit := _begun(problem, reading.measurement)) is not None]
    longer = [(reading, _continued(fit)) for reading, fit in sorted(begun, key=_deviance)[:CONTINUED]]
    last = [each for each in sorted(longer, key=_deviance)[:SURVIVORS] if each[1].deviance < as_read.deviance - NEAR]
    found = [(reading, _continued(fit, MAX_ITERATIONS)) for reading, fit in last]
    limit = min([as_read.deviance - margin, *(fit.deviance + NEAR for _, fit in found)])
    return [(reading, fit) for reading, fit in found if fit.deviance <= limit and _share_left(fit) <= PLAUSIBLE]


def _deviance(fitted: tuple[Reading, Fit]) -> float:
    return fitted[1].deviance


def _is_taken_by_unbalance(fit: Fit, factor: float) -> bool:
    """Whether a factor of all amplitudes equals a factor of the unbalance, so that no fit can tell.

    The unbalance lies inside its limits before and after, so that limits do not keep it from a better value.
    """
    parameters = fit.problem.parameters
    own = np.array([each.is_unbalance and each.prior is None for each in parameters])
    scaled = fit.x * np.where(own, factor, 1.0)
    inside = (np.abs(parameters.to_cube(x)[own] - 0.5) < 0.5 - AT_LIMIT for x in (fit.x, scaled))
    if factor == 1.0 or not all(map(np.all, inside)):
        return False
    response, of_scaled = fit.problem.response(np.array([fit.x, scaled]))
    return bool(np.allclose(of_scaled, factor * response, rtol=1e-6, atol=1e-9 * np.max(np.abs(response))))


def _begun(problem: Problem, measurement: Measurement) -> Fit | None:
    """The problem fitted to data by a few iterations from a few starts; None if that fails."""
    try:
        case = Case.of(problem, measurement)
        likelihood = likelihood_of(case)
        points = sobol(SCREENING, likelihood.d) + 0.5 / SCREENING
        starts = screened(case, points).apart(STARTS, START_DISTANCE).points
        first = [_climbed(likelihood, likelihood.start(u), FIRST_ITERATIONS) for u in starts]
        return Fit(likelihood, min(first, key=lambda point: point.deviance))
    except (SettingError, ArithmeticError, np.linalg.LinAlgError):
        return None


def _continued(fit: Fit, iterations: int = ITERATIONS) -> Fit:
    """The fit after further iterations; unchanged if these fail."""
    try:
        return Fit(fit.likelihood, _climbed(fit.likelihood, fit.point.theta, iterations))
    except (SettingError, ArithmeticError, np.linalg.LinAlgError):
        return fit


def _climbed(likelihood: Likelihood, theta: Array, iterations: int = MAX_ITERATIONS) -> Point:
    return maximise(likelihood, theta, max_iterations=iterations, tolerance=TOLERANCE)


def _share(noise: Noise, response: ComplexArray) -> float:
    """Median of the noise's standard deviation as a part of the response (n_speed, n_channel)."""
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
    """Statements common to all ways, then the statements of single ways."""
    common = [said for said in ways[0] if all(said in way for way in ways)]
    own = dict.fromkeys(said for way in ways for said in way if said not in common)
    return ", and ".join([*common, *(["; or ".join(own)] if own else [])])


def _per_cent(fit: Fit) -> str:
    share = 100 * _share_left(fit)
    return f"{share:.0f} %" if share < MOST else f"over {MOST} %"


MIL = INCH / 1000  # m
MAX_CHANNELS = 8  # of more, each alone is not taken for reversed: that would be many readings

AMPLITUDES = {  # how they were given, and what they must be multiplied by
    "amplitudes are in mil where µm are expected": MIL / MICROMETRE,
    "amplitudes are in mil peak to peak where µm 0-peak are expected": MIL / MICROMETRE / 2,
    "amplitudes were converted from mil though they were in µm": MICROMETRE / MIL,
    "amplitudes are peak to peak where 0-peak is expected": 1 / 2,
    "amplitudes were halved though they were 0-peak": 2.0,
    "amplitudes are rms where 0-peak is expected": np.sqrt(2),
    "amplitudes were converted from rms though they were 0-peak": np.sqrt(1 / 2),
}
SPEEDS = {
    "speeds are in Hz where rpm are expected": HERTZ / RPM,
    "speeds are in rad/s where rpm are expected": 1 / RPM,
    "speeds are in Hz where rad/s are expected": HERTZ,
    "speeds are in rpm where rad/s are expected": RPM,
}

NEAR_FACTOR = 0.03  # by which a fitted gain may differ from the factor of another unit


def unit_of_gain(gain: float) -> str:
    """Unit error that a gain of the amplitudes amounts to, in words; empty if the gain fits no unit.

    >>> unit_of_gain(25.5)
    'amplitudes were converted from mil though they were in µm'
    """
    known = [given for given, factor in AMPLITUDES.items() if abs(gain * factor - 1) < NEAR_FACTOR]
    return known[0] if known else ""


@dataclass(frozen=True)
class Reading:
    """Data read in another way: how they were given, the cure for each, and the data.

    They differ in one respect or two. `factor` multiplies all amplitudes if nothing else differs.
    """

    given: tuple[str, ...]
    remedies: tuple[str, ...]
    measurement: Measurement
    factor: float = 1.0


def readings(measurement: Measurement) -> Iterator[Reading]:
    """The data, whose noise must not be known, read in each other way."""
    if not measurement.is_amplitude:
        yield _lag(measurement)
        yield from _reversed(measurement)
    across = tuple(
        dataclasses.replace(item, direction=direction_at(ANGLES["y"] - item.angle)) for item in measurement.channels
    )
    yield Reading(
        ("x and y are swapped, or the shaft turns from y to x",),
        ("exchange x and y (direction)",),
        dataclasses.replace(measurement, channels=across),
    )
    yield from _of_planes(measurement)
    yield from _in_other_units(measurement)


def _of_planes(measurement: Measurement) -> Iterator[Reading]:
    """The two probes of one plane exchanged or reversed, if there are other planes.

    Swapped cables, a plane that was named from the other side, one signal inverted as well.
    """
    channels = measurement.channels
    planes = dict.fromkeys(channel.position for channel in channels)
    for plane in planes if len(planes) > 1 else ():
        there = [index for index, channel in enumerate(channels) if channel.position == plane and channel.is_1x]
        if len(there) != 2 or channels[there[0]].is_parallel_to(channels[there[1]]):
            continue
        first, second = (named(channels[index].direction) for index in there)
        both = f"{first} and {second}"
        swap = "exchange these two columns, or the cables of these probes"
        ways = [((1, 1), f"{both} are swapped at {plane:g} m alone", swap)]
        if not measurement.is_amplitude:
            ways += [
                ((-1, 1), f"{both} are swapped at {plane:g} m alone, and {first} is turned by 180°", f"{swap}, and add 180° to {first}"),
                ((1, -1), f"{both} are swapped at {plane:g} m alone, and {second} is turned by 180°", f"{swap}, and add 180° to {second}"),
            ]  # fmt: skip
        for signs, given, cure in ways:
            values = measurement.values.copy()
            values[:, there] = values[:, there[::-1]] * signs
            yield Reading((given,), (cure,), dataclasses.replace(measurement, values=values))


def double_readings(measurement: Measurement) -> Iterator[Reading]:
    """Two ways at once: many instruments show a lag, in units of their own."""
    if not measurement.is_amplitude:
        lag = _lag(measurement)
        for other in _in_other_units(lag.measurement):
            yield Reading(lag.given + other.given, lag.remedies + other.remedies, other.measurement)


def _lag(measurement: Measurement) -> Reading:
    return Reading(
        ("phases are lags where leads are expected",),
        ("change the sign of all phases (phase_lead_deg)",),
        dataclasses.replace(measurement, values=np.conj(measurement.values)),
    )


def _reversed(measurement: Measurement) -> Iterator[Reading]:
    """Probes that measure in the opposite direction: each one, both of a plane, or all of x or of y.

    If the phase origin is not known, the reversal of the others is equivalent.
    """
    channels = measurement.channels
    everyone = frozenset(range(len(channels)))
    single = [frozenset({index}) for index in everyone] if len(everyone) <= MAX_CHANNELS else []
    directions = sorted({channel.direction for channel in channels}, key=lambda name: (name not in DIRECTIONS, name))
    by_direction = [frozenset(i for i in everyone if channels[i].direction == name) for name in directions]
    planes = dict.fromkeys(channel.position for channel in channels)
    by_plane = [frozenset(i for i in everyone if channels[i].position == plane) for plane in planes]
    done = {frozenset[int](), everyone} if not measurement.phase_known else {frozenset[int]()}
    for group in chain(single, by_plane, by_direction):
        if group in done:
            continue
        same = [group] if measurement.phase_known else [group, everyone - group]
        done.update(same)
        fewest = min(map(len, same))
        probes = [", ".join(str(channels[i]) for i in sorted(each)) for each in same if len(each) == fewest]
        sign = np.where([index in group for index in range(len(channels))], -1.0, 1.0)
        yield Reading(
            (f"the phases of {' or else of '.join(probes)} are turned by 180°",),
            ("add 180° to these (phase_lead_deg)",),
            dataclasses.replace(measurement, values=sign * measurement.values),
        )


def _in_other_units(measurement: Measurement) -> Iterator[Reading]:
    for given, factor in AMPLITUDES.items():
        yield Reading(
            (f"{given} (× {factor:.4g})",),
            ("multiply amplitude_um_0pk and sigma_um by that, unless it is the model's unbalance that is wrong",),
            dataclasses.replace(measurement, values=factor * measurement.values),
            factor,
        )
    for given, factor in SPEEDS.items():
        yield Reading(
            (f"{given} (× {factor:.4g})",),
            ("multiply speed_rpm by that",),
            dataclasses.replace(measurement, speed=factor * measurement.speed),
        )


NEAR_BAND = 0.3  # part of a band's ends within which a critical speed still shapes its response
FAR = 8.0  # measured speeds that many times below the first critical are hardly those of a run-up
MAX_SITES = 60  # larger rotors take longer than a second
REACHES = (
    1 + NEAR_BAND,
    4.0,
    12.0,
    30.0,
    61.0,
)  # times the highest speed, one after the other until a critical is found
MISREAD = {"Hz": HERTZ / RPM, "rad/s": 1 / RPM}  # what a number of this unit is multiplied by to be one in rpm


def slips(case: Case, x: Array) -> tuple[str, ...]:
    """Remarks on the measured band compared with the critical speeds at values x (d,) SI.

    Empty if the problem does not know its modes, or is too large to compute them in passing.
    """
    speed = case.measurement.speed
    lowest, highest = float(np.min(speed)), float(np.max(speed))
    criticals = first_criticals(case.problem, x, highest)
    if criticals is None or np.any((criticals >= (1 - NEAR_BAND) * lowest) & (criticals <= (1 + NEAR_BAND) * highest)):
        return ()
    return (_no_critical_text(criticals, lowest, highest), *_unit_texts(criticals, lowest, highest))


def first_criticals(problem: Problem, x: Array, highest: float) -> Array | None:
    """Critical speeds up to the first reach that has one, rad/s; None where the problem cannot tell."""
    if not 0 < len(problem.sites) <= MAX_SITES:
        return None
    found = np.empty(0)
    try:
        for reach in REACHES:
            found = problem.critical_speeds(x, reach * highest)
            if len(found):
                break
    except (SettingError, ArithmeticError, ValueError, np.linalg.LinAlgError):
        return None
    return found


def _no_critical_text(criticals: Array, lowest: float, highest: float) -> str:
    band = f"{lowest / RPM:.0f} to {highest / RPM:.0f} rpm"
    said = (
        f"no critical speed of the model lies inside the measured band or within {100 * NEAR_BAND:.0f} % of it ({band})"
    )
    if not len(criticals):
        return said
    nearest = criticals[np.argmin(np.abs(np.log(criticals / highest)))]
    return f"{said}; the nearest one is at {nearest / RPM:.0f} rpm"


def _unit_texts(criticals: Array, lowest: float, highest: float) -> tuple[str, ...]:
    """A unit that the speeds may have been in, where they lie far below the first critical."""
    if not len(criticals) or highest >= criticals[0] / FAR:
        return ()
    fitting = [
        (unit, factor)
        for unit, factor in MISREAD.items()
        if np.any((criticals >= factor * lowest) & (criticals <= factor * highest))
    ]
    if not fitting:
        return ()
    units = " / ".join(unit for unit, _ in fitting)
    factors = " or ".join(f"{factor:.3g}" for _, factor in fitting)
    return (f"speeds look like {units}: {factors} times as high they enclose a critical speed; give them in rpm",)
