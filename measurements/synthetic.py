"""Synthetic measurements: the response of a problem at known values, with noise drawn on it.

Here, and nowhere in what identifies, the true values are known. Data may hide effects that the problem's model lacks:
`hidden` names them, their locations and sizes are drawn, and only the record of a run says what they were. A rotor that is
unstable anywhere up to the highest measured speed has no steady response there: it is drawn anew, or refused.

`runs` makes several runs of the machine, each at all speeds, with its own noise and its known weights. What is hidden is
drawn for the machine and acts in all runs; the first run is the same whatever runs follow it. Where `directions` say which way
the speed goes, an effect that depends on it acts in each run as that has it; its size is drawn on one run, which goes up unless the
effect itself says otherwise.
"""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError, unknown
from ksmea.measurement.campaign import RUN_DIRECTIONS, Campaign, Run, weights_of
from ksmea.measurement.measurement import OBSERVABLES, Layout, Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.numerics.differences import recent
from ksmea.plugins import registry
from ksmea.plugins.effect import AnyEffect
from ksmea.plugins.source import MeasurementSource, ProblemSettings
from ksmea.problem.alignment import aligned
from ksmea.problem.parameters import Parameter
from ksmea.problem.problem import Problem
from ksmea.records.hidden import HiddenEffect, TrueValue
from ksmea.settings.settings import setting
from ksmea.units import MICROMETRE, RPM
from measurements.drawn_numbers import NUMBERS, with_drawn_numbers
from measurements.hidden_size import drawn_size, size_of_drop

ROUTES = ("reduced", "dense")
MAX_DRAWS = 20  # of effects, for a stable rotor


@dataclass(frozen=True)
class Hidden:
    """An effect at its location, and its unknowns with their values (e,), SI."""

    name: str
    effect: AnyEffect
    parameters: tuple[Parameter, ...]
    theta: Array


@dataclass(frozen=True)
class Synthetic(MeasurementSource):
    """A measurement made by the problem's own model, perhaps on another mesh, with Gaussian noise.

    The paper says '10 % Gaussian noise' and not what it multiplies: here each value by its own standard deviation.
    """

    kind: str = setting(
        "amplitude", "what is measured: amplitudes, or complex responses with their phase", choices=OBSERVABLES
    )
    relative: float = setting(0.0, "standard deviation of the noise relative to each value", at_least=0)
    floor: float = setting(
        0.0, "standard deviation of the noise that is there without any response", unit="µm", at_least=0
    )
    noise_known: bool = setting(
        True, "tell the identification the noise's level; false: it is estimated, relative part and floor together"
    )
    stated: float = setting(
        1.0, "factor on the noise level that is given to the identification, if it is given", above=0
    )
    phase_known: bool = setting(
        True, "whether the phase origin is known; false: one more unknown, as with measured phases"
    )
    mesh: int | None = setting(
        None, "number of elements of the model that makes the data; null: the problem's", at_least=1
    )
    route: str = setting(
        "reduced",
        "how the data are computed: reduced, as the problem does it, or dense, a solve with the whole rotor at each speed",
        choices=ROUTES,
    )
    numbers: str = setting("stated", "numbers known to a tolerance: as stated, or drawn from it", choices=NUMBERS)
    truth: dict[str, float] = setting(
        {}, "true values in the units of the problem's parameters; a name left out: the published one"
    )
    hidden: list[str] = setting(
        [],
        "effects that are in the data but not in the model (`python -m bench help effect`), locations and sizes drawn",
    )
    sizes: dict[str, float] = setting(
        {}, "sizes of hidden effects by name of their parameters, in their units; a name left out: drawn"
    )
    expected_drop: float | None = setting(
        None,
        "deviance that a fit without it leaves of each hidden effect alone, by which its drawn size is scaled; null: sizes that"
        " change the response by its own size",
        above=0,
    )
    harmonics: list[float] = setting(
        [],
        "multiples of the speed of rotation that each probe is read at in addition to 1X, such as [2,3]; with complex data and a floor,"
        " since a model without effects has no response there",
    )
    runs: list[str] = setting(
        [],
        "all runs of the machine, each with its own noise: bare, or known weights as g mm @ m @ degrees, joined by +, such"
        " as [bare,150@0.2,150@0.2@30+80@1]; an empty list: one run, bare",
    )
    directions: list[str] = setting(
        [],
        "which way the speed goes in each of runs: up, down or steady, such as [up,down], for what is hidden and depends on it;"
        " an empty list: not known",
    )

    def check(self) -> None:
        for name in self.hidden:
            if name not in registry.registered("effect"):
                raise unknown("effect in hidden:", name, registry.registered("effect"))
        if self.sizes and not self.hidden:
            raise SettingError("sizes: expected hidden effects that have them, got none; name them in hidden")
        if self.expected_drop is not None and not self.hidden:
            raise SettingError("expected_drop: expected hidden effects that make it, got none; name them in hidden")
        if self.expected_drop is not None and self.noise.is_absent:
            raise SettingError("expected_drop: expected noise, by which a deviance is measured, got none; give one")
        for run in self.runs:
            weights_of(run)
        for direction in self.directions:
            if direction not in RUN_DIRECTIONS:
                raise unknown("direction in directions:", direction, RUN_DIRECTIONS)
        if self.directions and len(self.directions) != len(self.runs):
            raise SettingError(
                f"directions: expected one for each of runs, which are {len(self.runs)}, got {len(self.directions)}; give as many, such as"
                " runs=[bare,bare] and directions=[up,down]"
            )
        if self.harmonics and (Observable(self.kind) is not Observable.COMPLEX or not self.floor):
            raise SettingError(
                f"harmonics: expected kind=complex and a floor above 0, got kind={self.kind} and {self.floor:g} µm; amplitudes and"
                " noise relative to a response are zero if it is zero"
            )
        if len(set(self.harmonics)) < len(self.harmonics) or 1 in self.harmonics:
            raise SettingError(f"harmonics: expected each once and none of them 1, got {self.harmonics}; leave it out")

    def layout(self, settings: ProblemSettings) -> Layout:
        """The problem's own speeds and channels."""
        return self._layout(settings.build())

    def true_values(self, settings: ProblemSettings) -> dict[str, float]:
        """True value of every unknown by name, SI; 0 for unknowns that this measurement adds.

        Raises `SettingError` for a missing name or location, or an unstable rotor.
        """
        values, rng = self._values(settings), np.random.default_rng(0)
        if self.expected_drop is None:
            self._hide(settings, values, rng)
        else:  # sizes by a deviance take fits
            taken: list[AnyEffect] = []
            for name in self.hidden:
                taken.append(_drawn_location(name, self._machine(settings), self._seen(settings), taken, rng))
        return values

    def _values(self, settings: ProblemSettings) -> dict[str, float]:
        built = settings.build()
        own = built.parameters.names
        units = {parameter.name: parameter.si_per_unit for parameter in self._as_measured(built).parameters}
        values = {name: 0.0 for name in units if name not in own} | dict(self._source(settings).reference())
        for name, value in self.truth.items():
            if name not in units:
                raise unknown("parameter in measurement.truth:", name, units)
            values[name] = value * units[name]
        missing = [name for name in units if name not in values]
        if missing:
            raise SettingError(
                f"expected a value for {', '.join(missing)}, got none; give"
                f" measurement.truth='{{{', '.join(f'{name}: …' for name in missing)}}}', or a reference in the file of the rotor",
                setting="measurement.truth",
            )
        return {name: values[name] for name in units}

    def measure(
        self,
        settings: ProblemSettings,
        truth: Mapping[str, float],
        noise: np.random.Generator,
        hidden: np.random.Generator,
    ) -> Measurement:
        """One noisy measurement of the problem at the true values (SI); effects are drawn by `hidden`."""
        layout = self._layout(self._source(settings).build())
        response = self.response(settings, truth, hidden)
        values = np.concatenate([observe(response[rows], self.kind, self.noise, noise) for rows in layout.rows])
        stated_noise = self.noise.scaled(self.stated) if self.noise_known else None
        return Measurement(
            layout.speed, layout.channels, values, stated_noise, layout.source, layout.phase_known, layout.campaign
        )

    @property
    def noise(self) -> Noise:
        """The noise that is drawn, SI."""
        return Noise(self.relative, self.floor * MICROMETRE)

    @property
    def parts(self) -> list[Any]:
        """Plugins other than the problem that the data are made with."""
        return [registry.create("effect", name, {}) for name in self.hidden]

    def response(
        self, settings: ProblemSettings, truth: Mapping[str, float], hidden: np.random.Generator
    ) -> ComplexArray:
        """The noise-free response (n_speed, n_channel), m, that is measured."""
        problem = self._as_measured(self._source(settings).build())
        own = np.array([truth[name] for name in problem.parameters.names])
        problem, theta = _with(problem, self._hide(settings, truth, hidden))
        x = np.concatenate([own, theta])
        if self.numbers == "drawn":
            problem, x = with_drawn_numbers(problem, x, hidden)
        return problem.response(x[None])[0] if self.route == "reduced" else problem.dense_response(x[None])[0]

    def hidden_effects(self, settings: ProblemSettings, hidden: np.random.Generator) -> tuple[HiddenEffect, ...]:
        """Effects that data drawn by `hidden` hide: name, location, and values in their units."""
        effects = self._hide(settings, self._values(settings), hidden)
        return tuple(HiddenEffect(each.name, str(each.effect), _true_values(each)) for each in effects)

    def with_hidden(
        self, settings: ProblemSettings, problem: Problem, hidden: np.random.Generator
    ) -> tuple[Problem, Array] | None:
        """Problem with what data drawn by `hidden` hide, and true values (e,) SI of the added unknowns."""
        if not self.hidden:
            return None
        return _with(problem, self._hide(settings, self._values(settings), hidden))

    def _hide(
        self, settings: ProblemSettings, truth: Mapping[str, float], rng: np.random.Generator
    ) -> Sequence[Hidden]:
        """Effects that data of a problem hide, at true values (SI) of its unknowns; the last ones are kept."""

        def drawn() -> tuple[Sequence[Hidden], Mapping[str, Any]]:
            return self._effects(self._machine(settings), self._seen(settings), truth, rng), rng.bit_generator.state

        key = (repr(settings), tuple(sorted(truth.items())), repr(rng.bit_generator.state))
        effects, after = recent(self._drawn_last, key, drawn, 1)
        rng.bit_generator.state = after
        return effects

    @cached_property
    def _drawn_last(self) -> OrderedDict[Hashable, tuple[Sequence[Hidden], Mapping[str, Any]]]:
        return OrderedDict()

    def _effects(
        self, problem: Problem, seen: Measurement, truth: Mapping[str, float], rng: np.random.Generator
    ) -> list[Hidden]:
        x = np.array([truth[name] for name in problem.parameters.names])
        if not problem.is_stable(x):
            raise _unstable("measurement.truth", problem, x)
        for _ in range(MAX_DRAWS):
            extended, effects, is_drawn = self._drawn(problem, seen, x, rng)
            values = np.concatenate([x, *(each.theta for each in effects)])
            if not effects or extended.is_stable(values):
                return effects
            if not is_drawn:
                raise _unstable("measurement.sizes", extended, values)
        raise SettingError(
            f"expected a rotor that is stable with {', '.join(self.hidden)}, got none in {MAX_DRAWS} draws;"
            " give measurement.sizes",
            setting="measurement.hidden",
        )

    def _drawn(
        self, problem: Problem, seen: Measurement, x: Array, rng: np.random.Generator
    ) -> tuple[Problem, list[Hidden], bool]:
        """The problem with effects, and whether any of their sizes was drawn."""
        extended, found, sized, is_drawn = problem, list[Hidden](), set(), False
        for name in self.hidden:
            effect = _drawn_location(name, problem, seen, [each.effect for each in found], rng)
            try:
                theta = self._size(effect, extended, x, rng)
                extended = effect.added_to(extended)
            except SettingError as error:
                raise SettingError(f"{name}: {error}", setting="measurement.hidden") from error
            parameters = extended.parameters.items[len(x) :]
            for index, parameter in enumerate(parameters):
                if parameter.name in self.sizes:
                    theta[index] = _within(parameter, self.sizes[parameter.name])
                is_drawn |= parameter.name not in self.sizes
                sized.add(parameter.name)
            found.append(Hidden(name, effect, parameters, theta))
            x = np.concatenate([x, theta])
        for name in self.sizes:
            if name not in sized:
                raise unknown("parameter in measurement.sizes:", name, sized)
        return extended, found, is_drawn

    def _size(self, effect: AnyEffect, problem: Problem, x: Array, rng: np.random.Generator) -> Array:
        """Values (e,) SI of an effect's unknowns, drawn."""
        if self.expected_drop is None:
            return drawn_size(effect, problem, x, Observable(self.kind), rng)
        return size_of_drop(effect, problem, x, self.expected_drop, self.noise, Observable(self.kind), rng)

    def _machine(self, settings: ProblemSettings) -> Problem:
        """The model that makes the data, as far as the problem knows it, in one run without weights."""
        problem = self._source(settings).build()
        return aligned(problem, self._layout_of_one(problem))

    def _seen(self, settings: ProblemSettings) -> Measurement:
        """The measurement with all values 0: its runs and channels, by which effects say how they act."""
        layout = self._layout(self._source(settings).build())
        values = Observable(self.kind).seen(np.zeros((len(layout.speed), len(layout.channels)), dtype=complex))
        return Measurement(layout.speed, layout.channels, values, None, layout.source, campaign=layout.campaign)

    def _as_measured(self, problem: Problem) -> Problem:
        return aligned(problem, self._layout(problem))

    def _layout(self, problem: Problem) -> Layout:
        one, n_run = self._layout_of_one(problem), len(self.runs)
        if not n_run:
            return one
        runs = (
            Run(f"run{number}", len(one.speed), weights_of(run), direction)
            for number, (run, direction) in enumerate(zip(self.runs, self.directions or [""] * n_run), start=1)
        )
        return dataclasses.replace(one, speed=np.tile(one.speed, n_run), campaign=Campaign(tuple(runs)))

    def _layout_of_one(self, problem: Problem) -> Layout:
        own = problem.channels
        further = (dataclasses.replace(each, harmonic=harmonic) for harmonic in self.harmonics for each in own)
        return Layout(problem.speed, (*own, *further), self.kind, "synthetic", self.phase_known)

    def _source(self, settings: ProblemSettings) -> ProblemSettings:
        if self.mesh is None:
            return settings
        if "mesh" not in {field.name for field in dataclasses.fields(settings)}:
            raise SettingError(
                "expected a problem with a mesh, got one without; leave it null", setting="measurement.mesh"
            )
        try:
            changed: Any = {"mesh": self.mesh}
            return dataclasses.replace(settings, **changed)
        except SettingError as error:
            raise SettingError(f"measurement.{error}") from error


def _with(problem: Problem, effects: Sequence[Hidden]) -> tuple[Problem, Array]:
    """The problem with hidden effects in all its runs, and the values (e,) SI of their unknowns."""
    for each in effects:
        problem = each.effect.added_to(problem)
    return problem, np.concatenate([np.empty(0), *(each.theta for each in effects)])


def _unstable(where: str, problem: Problem, x: Array) -> SettingError:
    highest = float(np.max(problem.speed))
    threshold = problem.stability_threshold(x, highest)
    since = f"from {threshold / RPM:.0f} rpm" if threshold else "from rest"
    return SettingError(
        f"expected a rotor that is stable up to its highest measured speed, {highest / RPM:.0f} rpm, got one whose"
        f" free motions grow {since}, without a steady response; give other values",
        setting=where,
    )


def _true_values(hidden: Hidden) -> tuple[TrueValue, ...]:
    return tuple(
        TrueValue(item.name, item.unit, float(value / item.si_per_unit))
        for item, value in zip(hidden.parameters, hidden.theta)
    )


def _within(parameter: Parameter, size: float) -> float:
    """A size in the parameter's unit as SI, if it is physical."""
    value = size * parameter.si_per_unit
    if not parameter.lower <= value <= parameter.upper:
        limits = f"{parameter.lower / parameter.si_per_unit:g} to {parameter.upper / parameter.si_per_unit:g}"
        raise SettingError(
            f"expected {parameter.name} from {limits} {parameter.unit}, which is physical, got {size:g}",
            setting="measurement.sizes",
        )
    return value


def _drawn_location(
    name: str, problem: Problem, seen: Measurement, taken: Sequence[AnyEffect], rng: np.random.Generator
) -> AnyEffect:
    """Effect, as in the measured runs, at a free location, each with equal probability."""
    try:
        effect: AnyEffect = registry.create("effect", name, {})
        effect = effect.seen_in(seen) or effect
        locations = [located for located in effect.locations(problem) if located not in taken]
    except (SettingError, AttributeError) as error:
        raise SettingError(
            f"expected a problem that effects can be added to, got {type(problem).__name__} ({error})",
            setting="measurement.hidden",
        ) from error
    if not locations:
        raise SettingError(
            f"expected effects that have a location here, got {name}; {effect.if_nowhere}", setting="measurement.hidden"
        )
    return locations[rng.integers(len(locations))]
