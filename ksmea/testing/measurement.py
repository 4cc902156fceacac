"""The exam of measurement sources: kind, shapes, units, noise, and one line for what cannot be read."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ksmea.arrays import Array, as_real
from ksmea.errors import SettingError
from ksmea.measurement.measurement import OBSERVABLES, Measurement
from ksmea.plugins.source import MeasurementSource, ProblemSettings
from ksmea.problem.alignment import aligned, require_aligned
from ksmea.testing.exam import Exam, ExamFailed, require
from ksmea.testing.jeffcott import JeffcottRotor
from ksmea.testing.repeat import Drawn, same_seed_same_result, shared_generators_play_no_part
from ksmea.testing.settings import OF_SETTINGS

LARGEST = 0.1  # m: no shaft vibrates by more
FASTEST = 2e5  # rad/s, 2 million rpm
N_REPEAT = 10  # measurements, whose noise is looked at together
MOST_ERRORS = 4.0  # sampling errors that the rms of noise may be off: one draw in 16 000
NO_FILE = {"path": "no_such_file"}


@dataclass(frozen=True)
class MeasurementCase(Drawn):
    """Source of measurements, the problem `of` which one is made, and settings to reject (`bad`).

    A source that has a `path` must reject a file that does not exist.
    """

    contract: ClassVar = MeasurementSource
    plugin: MeasurementSource
    of: ProblemSettings = field(default_factory=JeffcottRotor)
    bad: Sequence[Mapping[str, Any]] = ()

    @property
    def truth(self) -> Mapping[str, float]:
        return self.plugin.true_values(self.of)

    def measure(self, seed: int) -> Measurement:
        return self.plugin.measure(self.of, self.truth, *_streams(seed))

    @cached_property
    def measurement(self) -> Measurement:
        return self.measure(1)

    def outcome(self, seed: int) -> Array:
        return as_real(self.measure(seed).values.ravel())


def _streams(seed: int) -> tuple[np.random.Generator, np.random.Generator]:
    """Generators of the noise and of what is hidden."""
    return np.random.default_rng([seed, 0]), np.random.default_rng([seed, 1])


def measures_what_it_says(case: MeasurementCase) -> None:
    """Kind, speeds, channels and phases are as `kind` and `layout` state beforehand."""
    found, layout = case.measurement, case.plugin.layout(case.of)
    require(
        case.plugin.kind in OBSERVABLES,
        f"a kind of {', '.join(OBSERVABLES)}",
        repr(case.plugin.kind),
        "take one of them",
    )
    stated = f"{case.plugin.kind} of {len(layout.speed)} speeds and {len(layout.channels)} channels"
    same = (
        found.kind == layout.kind == case.plugin.kind
        and np.array_equal(found.speed, layout.speed)
        and tuple(found.channels) == tuple(layout.channels)
        and (found.phase_known, found.campaign) == (layout.phase_known, layout.campaign)
    )
    got = f"{found.kind} of {len(found.speed)} and {len(found.channels)}, or others"
    require(same, f"{stated}, as stated", got, "leave layout out, or make both of the same data")


def speeds_and_values_are_si(case: MeasurementCase) -> None:
    """Speeds are in rad/s and values in m, 0 to peak."""
    found = case.measurement
    largest, fastest = float(np.max(np.abs(found.values))), float(np.max(np.abs(found.speed)))
    require(
        largest <= LARGEST, f"values up to {LARGEST:g} m", f"{largest:.3g}", "give them in m: 1e-6 times micrometres"
    )
    require(
        np.all(found.speed > 0) and fastest <= FASTEST,
        f"speeds above 0 and up to {FASTEST:g} rad/s",
        f"{np.min(found.speed):.3g} to {fastest:.3g}",
        "give them in rad/s: rpm times ksmea.units.RPM",
    )


def problem_can_be_seen_so(case: MeasurementCase) -> None:
    """A problem can be evaluated at its speeds and channels."""
    require_aligned(aligned(case.of.build(), case.measurement), case.measurement)


def noise_is_what_it_tells(case: MeasurementCase) -> None:
    """The noise is handed over if it is known; if the response without it is known too, its size is right."""
    found, noise = case.measurement, case.plugin.noise
    if not case.plugin.noise_known:
        require(found.noise is None, "no noise in the measurement, as noise_known says", "some", "leave it out there")
    if noise is None or noise.is_absent:
        return
    squares = []
    for seed in range(N_REPEAT):
        found = case.measure(seed)
        response = case.plugin.response(case.of, case.truth, _streams(seed)[1])
        if response is None:
            return
        expected, shape = found.seen(response), found.values.shape
        require(expected.shape == shape, f"a response {shape}", expected.shape, "one a datum, without noise")
        squares.append(np.abs((found.values - expected) / noise.sd(np.abs(expected))) ** 2)
    deviation = float(np.sqrt(np.mean(squares)))
    sampling_error = 1 / np.sqrt(2 * found.dimensions * np.size(squares))
    require(
        abs(deviation - 1) < MOST_ERRORS * sampling_error,
        f"noise of 1 ± {MOST_ERRORS * sampling_error:.2g} times its level",
        f"{deviation:.3g} times",
        "draw it by ksmea.measurement.measurement.observe, in m",
    )


def true_values_are_of_its_unknowns(case: MeasurementCase) -> None:
    """True values are known of all unknowns of the problem, or of none; in SI."""
    names, known = aligned(case.of.build(), case.measurement).parameters.names, case.truth
    missing = sorted(set(names) - set(known)) if known else []
    require(not missing, f"true values of {', '.join(names)}, or of none", f"none of {', '.join(missing)}", "tell them")


def bad_input_is_refused(case: MeasurementCase) -> None:
    """Input that cannot be read is rejected in one line."""
    fields = {each.name for each in dataclasses.fields(case.plugin)}
    for settings in (*([NO_FILE] if "path" in fields else []), *case.bad):
        try:
            dataclasses.replace(case, plugin=dataclasses.replace(case.plugin, **settings)).measure(1)
        except SettingError as error:
            require(
                "\n" not in str(error), "a refusal in one line", repr(str(error)), "name the line, and say it in one"
            )
            continue
        except Exception as error:
            got = f"{type(error).__name__}: {error}"
        else:
            got = "a measurement"
        raise ExamFailed(
            f"expected a SettingError of {dict(settings)}, got {got}; say in one line what was expected, what came and what to"
            " try"
        )


def measurement_properties(case: MeasurementCase) -> Sequence[Callable[[MeasurementCase], None]]:
    return (
        *OF_SETTINGS,
        measures_what_it_says,
        speeds_and_values_are_si,
        problem_can_be_seen_so,
        noise_is_what_it_tells,
        true_values_are_of_its_unknowns,
        bad_input_is_refused,
        same_seed_same_result,
        shared_generators_play_no_part,
    )


check_measurement = Exam(MeasurementCase, measurement_properties)
