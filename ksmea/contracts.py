"""The contracts between the framework and plugins.

A plugin is one file: a frozen dataclass whose fields are its settings, which subclasses one of the classes here, and one entry point.
`ksmea.registry` refuses what registers without. What is not abstract may be left out: its docstring says what then holds.
Points are rows of the unit cube, (n, d) in [0, 1]; parameter vectors are SI, in the order of `Problem.parameters`.
Sign convention: a real response is Re(q e^{iΩt}); complex responses q are in m, 0-peak.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Self, TypeVar

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.campaign import Campaign
from ksmea.channel import Channel
from ksmea.differences import CUBE_STEP, differenced
from ksmea.errors import SettingError
from ksmea.force_laws import Law
from ksmea.given import Given
from ksmea.identification import Identification, Streams
from ksmea.load import Load
from ksmea.measurement import Layout, Measurement, Noise
from ksmea.modes import Campbell, Mode
from ksmea.objective import Minimum, Objective
from ksmea.parameters import PHASE_ORIGIN, Parameter, Parameters
from ksmea.predictor import Predictor
from ksmea.records.hidden import HiddenEffect
from ksmea.response_structure import ResponseStructure, UnknownImpedance
from ksmea.settings import Settings, part_fields
from ksmea.stability import grows_nowhere, lowest_unstable_speed

Seen = TypeVar("Seen", bound="Problem")  # the kind of problems that an effect can be added to
METHOD_PARTS = ("surrogate", "optimizer", "samples")  # what a method may own, each chosen by name or number in a run


class Problem(ABC):
    """A rotor with unknowns, seen at given speeds through given channels. It never knows the true values.

    Attributes or properties of every problem: `parameters`, the unknowns; `speed`, (n_speed,) rad/s; `channels`; `campaign`, the
    runs that its speeds belong to, None where they are those of one run without known weights.
    """

    if TYPE_CHECKING:  # read-only; a property would become the default of a dataclass's field of that name

        @property
        def parameters(self) -> Parameters: ...
        @property
        def speed(self) -> Array: ...
        @property
        def channels(self) -> tuple[Channel, ...]: ...
        @property
        def campaign(self) -> Campaign | None: ...
    else:
        parameters: Parameters
        speed: Array
        channels: tuple[Channel, ...]
        campaign = None

    # Which of what may be left out it has
    has_sensitivity = Given("sensitivity")
    can_leave_phase_open = Given("with_phase_origin")
    takes_unbalance = Given("with_unbalance")
    takes_loads = Given("load_response")
    has_dense_route = Given("dense_response")
    knows_stability = Given("growth_rate")

    @abstractmethod
    def response(self, x: Array) -> ComplexArray:
        """(n, d) SI → (n, n_speed, n_channel), m."""

    def at(self, speed: Array, channels: Sequence[Channel]) -> Problem:
        """The same rotor at other speeds (rad/s) and channels. Left out: it is only seen as it is."""
        raise self._refusal("can be seen at other speeds and channels", "measure what it has, or give it `at`")

    @property
    def machine(self) -> Problem:
        """What effects are told of: the problem itself; of several runs the machine that all of them saw."""
        return self

    def changed(self, change: Callable[[Problem], Problem]) -> Problem:
        """The problem with its machine changed, in all its runs."""
        return change(self)

    def sensitivity(self, x: Array) -> ComplexArray:
        """(d,) SI → ∂response/∂x, (n_speed, n_channel, d), m per SI unit. Left out: differences, counted as evaluations."""
        raise self._refusal("has a sensitivity", "take differences of its response (`ksmea.model.Model.linearise`)")

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response (n_speed, n_channel) and sensitivity at x (d,) SI, together one Jacobian. Left out: one after the other."""
        return self.response(x[None])[0], self.sensitivity(x)

    def linearises_cheaply(self, loads: Sequence[Load] = ()) -> bool:
        """Whether `linearised_per_load` costs no more than a few responses at single points. Left out: it does not."""
        return False

    @property
    def costly(self) -> Indices:
        """Indices of the unknowns each new value of which costs far more than one of the others. Left out: none are."""
        return np.empty(0, dtype=int)

    @property
    def sites(self) -> Array:
        """Where along the shaft a probe could look or a trial weight could sit, (n,) m. Left out: nowhere is known."""
        return np.empty(0)

    @property
    def landmarks(self) -> Mapping[str, float]:
        """What sits where along the shaft, in words, m: for texts and drawings. Left out: nothing is known."""
        return {}

    @property
    def has_free_phase(self) -> bool:
        """Whether the phase of the whole response is unknown. Left out: where `phase_origin` is one of its unknowns."""
        return PHASE_ORIGIN in self.parameters.names

    def with_phase_origin(self) -> Problem:
        """The same rotor with the phase of all unbalance unknown; itself where it is so. Left out: it has no use for such."""
        raise self._refusal("can leave the origin of its phases open", "use the amplitudes alone")

    def with_unbalance(self, position: float, magnitude: float, phase: float) -> Problem:
        """The same rotor with a known unbalance (kg m, rad) added at a position (m). Left out: it takes none."""
        raise self._refusal("takes a trial unbalance", "leave the trial run out")

    def with_unknown_unbalance(self, position: float, names: tuple[str, str], at_most: float) -> Problem:
        """The same rotor with an unknown unbalance added at a position (m): two unknowns of these names, its components at 0° and
        90° within ± `at_most` (kg m). Left out: it takes none."""
        raise self._refusal("takes an unknown weight", "give the weight's g_mm")

    def going(self, direction: str) -> Problem:
        """As the speed goes in one run of a campaign: up, down, steady, or '' where nobody says. Left out: as it is."""
        return self

    def next_to(self, motion: ComplexArray) -> Problem:
        """The same; of several steady motions that next to which its nonlinear force moves (n_speed, 2), m at 1X. Left out: it has one."""
        return self

    def unbalance(self, x: Array) -> Mapping[float, complex]:
        """Its unbalance at x (d,) SI by position (m), kg m, angles as of `with_unbalance`. Left out: it cannot tell."""
        return {}

    @property
    def unknown_impedances(self) -> tuple[UnknownImpedance, ...]:
        """Its unknown impedances, where its response is linear and made by these and `unbalance`. Left out: it cannot tell."""
        return ()

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        """Response to unit loads at 1X, (n, d) SI → (n, n_speed, n_channel, n_load) m per N or N m. Left out: it takes none."""
        raise self._refusal("takes loads on its shaft", "take one that is made of a rotor")

    def response_and_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        """`response` and `load_response` at the same points, which a problem may know by one solution."""
        return self.response(x), self.load_response(x, loads)

    def linearised_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        """`response` and then `load_response` at x (d,) SI as columns (n_speed, n_channel, 1 + n_load), and their derivatives
        (…, d) per SI unit. Left out: by central differences of both, or without loads as `linearised` has them."""
        if not loads and self.has_sensitivity:
            response, sensitivity = self.linearised(x)
            return response[..., None], sensitivity[:, :, None]

        def columns(points: Array) -> ComplexArray:
            if not loads:
                return self.response(points)[..., None]
            response, per_load = self.response_and_per_load(points, loads)
            return np.concatenate([response[..., None], per_load], axis=-1)

        return differenced(columns, x, CUBE_STEP * self.parameters.width, self.parameters.lower, self.parameters.upper)

    def dense_response(self, x: Array) -> ComplexArray:
        """`response` by a second, slower route, for comparison and for making data. Left out: there is none."""
        raise self._refusal("has a dense route", "give measurement.route=reduced")

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        """Speeds (rad/s) up to `highest` at which a damped natural frequency equals the spin speed, rising, at values
        x (d,) SI; None: up to its own highest speed. Left out: it does not know its modes."""
        raise self._knows_no_modes()

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        """Its damped natural modes at x (d,) SI and a spin speed (rad/s), the first `n_mode` or all. Left out: as above."""
        raise self._knows_no_modes()

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        """Natural frequencies and damping ratios of its first modes over spin speeds (n_speed,) rad/s. Left out: as above."""
        raise self._knows_no_modes()

    def growth_rate(self, x: Array, speed: Array) -> Array:
        """The largest real part of any damped eigenvalue (1/s) at values x (d,) SI and each spin speed (n_speed,) rad/s:
        above 0 a free motion grows, and no steady response exists. Left out: it cannot tell."""
        raise self._refusal("knows its damped eigenvalues", "take one that is made of a rotor")

    def stability_threshold(self, x: Array, highest: float) -> float:
        """The lowest spin speed (rad/s) up to `highest` at which a free motion grows at x (d,) SI; 0: from rest, inf: nowhere."""
        return lowest_unstable_speed(lambda speed: self.growth_rate(x, speed), highest)

    def is_stable(self, x: Array) -> bool:
        """Whether no free motion grows at values x (d,) SI at any spin speed up to its highest, as far as it can tell."""
        return not self.knows_stability or grows_nowhere(lambda at: self.growth_rate(x, at), float(np.max(self.speed)))

    def _knows_no_modes(self) -> SettingError:
        return self._refusal("knows its natural modes", "take one that is made of a rotor")

    def _refusal(self, what: str, try_this: str) -> SettingError:
        return SettingError(f"expected a problem that {what}, got {type(self).__name__}; {try_this}")


@dataclass(frozen=True)
class ProblemSettings(Settings):
    """What registers under `ksmea.problems`: settings that build a problem, and the published values of its unknowns. They are
    apart so that what is handed to an identification cannot hold the values it is to find."""

    @abstractmethod
    def build(self) -> Problem:
        """The problem, without any value of its unknowns."""

    def reference(self) -> Mapping[str, float]:
        """Published values by parameter name, SI, for synthetic data and tables alone. Left out: none are known."""
        return {}


@dataclass(frozen=True)
class MeasurementSource(Settings):
    """What registers under `ksmea.measurements`: where a measurement comes from. The defaults are those of a source that
    knows no truth, such as real data; `read` or `measure`, `kind` and, where known, `noise` are all that one has to say."""

    @property
    @abstractmethod
    def kind(self) -> str:
        """One of `ksmea.measurement.KINDS`."""

    def read(self) -> Measurement:
        """The measurement, of a source that holds one whatever the problem is: a file. Left out: it makes its own."""
        raise SettingError(f"expected a source that holds a measurement, got {type(self).__name__}; give it a problem")

    def measure(
        self,
        settings: ProblemSettings,
        truth: Mapping[str, float],
        noise: np.random.Generator,
        hidden: np.random.Generator,
    ) -> Measurement:
        """One measurement of the problem that `settings` build. Only what makes data uses the true values (SI by name)
        and the generators, of the noise and of effects that are hidden in the data. Left out: what it holds (`read`)."""
        return self.read()

    def layout(self, settings: ProblemSettings) -> Layout:
        """Speeds, channels and kind of every measurement, before one is made. Left out: as `measure` returns them."""
        unused = np.random.default_rng(0)
        return self.measure(settings, {}, unused, unused).layout

    @property
    def noise(self) -> Noise | None:
        """The noise in the data. Left out: nobody knows it."""
        return None

    @property
    def noise_known(self) -> bool:
        """Whether an identification is told the noise. Left out: where it is known at all."""
        return self.noise is not None

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a report should say of the data, such as what was left out. Left out: nothing."""
        return ()

    def true_values(self, settings: ProblemSettings) -> Mapping[str, float]:
        """True value of every unknown of the aligned problem by name, SI. Left out: nobody knows any."""
        return {}

    def response(
        self, settings: ProblemSettings, truth: Mapping[str, float], hidden: np.random.Generator
    ) -> ComplexArray | None:
        """What is measured, without its noise, (n_speed, n_channel) m. Left out: nobody knows it."""
        return None

    def hidden_effects(self, settings: ProblemSettings, hidden: np.random.Generator) -> tuple[HiddenEffect, ...]:
        """What data drawn by `hidden` hide, for records. Left out: nothing that anyone knows of."""
        return ()

    def with_hidden(
        self, settings: ProblemSettings, problem: Problem, hidden: np.random.Generator
    ) -> tuple[Problem, Array] | None:
        """A problem with what data drawn by `hidden` hide, and true values (e,) SI of the unknowns added. Left out: None."""
        return None


@dataclass(frozen=True)
class Effect(Settings, Generic[Seen]):
    """A physical cause that a model may lack, at one location; what registers under `ksmea.effects` is such an effect with
    its default location. How it changes a response is between it and the kind of problems that it can be added to."""

    # Effects that can look alike, by name, and what separates them. Left out: none.
    aliases: ClassVar[Mapping[str, str]] = MappingProxyType({})
    if_nowhere: ClassVar[str] = "leave it out"  # what a message says to do where a problem has no location for it
    # Whether it is fitted from values all over its limits, as what moves or hides resonances asks for. Left out: yes.
    is_scanned: ClassVar[bool] = True

    def locations(self, problem: Seen) -> Sequence[Self]:
        """This effect at each location of the problem where it may sit; empty where it cannot be. Left out: as it is."""
        return (self,)

    def seen_in(self, measurement: Measurement) -> Self | None:
        """This effect with what a measurement says of it besides its values, such as the direction of a run; None where nothing
        speaks for it, and it is tried only where it is asked for by name. Left out: as it is."""
        return self

    def path(self, problem: Seen) -> Array:
        """Values (n, e) SI leading away from 0: fits go along them, each from the last one. Left out: a scan instead."""
        return np.empty((0, 0))

    @abstractmethod
    def parameters(self, problem: Seen) -> tuple[Parameter, ...]:
        """Its unknowns with physical limits. At 0 of all of them the model is as without it."""

    @abstractmethod
    def added_to(self, problem: Problem) -> Problem:
        """The problem with this effect, whose unknowns follow its own: a problem like any other."""

    def places(self, problem: Seen) -> Sequence[float]:
        """Where on the shaft it acts alone, or whose reading it changes, m: a second opinion on its name. Left out: nowhere."""
        return ()

    def force_at(self) -> tuple[float, Law] | None:
        """Where a force acts alone, m, and the nonlinear law that its unknowns are coefficients of. Left out: nowhere."""
        return None

    @abstractmethod
    def draw(self, problem: Seen, rng: np.random.Generator) -> Array:
        """Plausible values (e,) SI within their limits, for data that hide it (`measurements/hidden_size.py` scales them)."""


AnyEffect = Effect[Any]  # on whatever kind of problems


@dataclass(frozen=True)
class Surrogate(Settings):
    """Settings of a surrogate. `transform` names how the real outputs are made of the complex response
    (`ksmea.transforms.TRANSFORMS`): a setting where the user may choose, else a class constant; left out: 'auto'."""

    transform = "auto"
    is_true_model: ClassVar[bool] = False  # whether a method evaluates the true model in its place and fits nothing

    def told_of(self, structure: ResponseStructure) -> Surrogate:
        """This surrogate for one problem, of which it is told what is known beside samples. Left out: it makes no use of it."""
        return self

    @abstractmethod
    def least_samples(self, d: int) -> int:
        """The fewest samples it can be fitted to in d dimensions."""

    @abstractmethod
    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        """A predictor from samples u (n, d) in the unit cube with outputs y (n, q); or `ksmea.unsuited.Unsuited`."""

    def refit(self, previous: Predictor, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        """`fit` that may start from an earlier predictor of fewer samples. Left out: `fit`."""
        return self.fit(u, y, rng)


@dataclass(frozen=True)
class Optimizer(Settings):
    """Settings of an optimiser."""

    @abstractmethod
    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Ask the objective for values and return `objective.result()`; let `BudgetSpent` pass."""

    def check_dimension(self, dim: int) -> None:
        """Raise `SettingError` where it does not suit `dim` unknowns. Left out: it suits any number."""


@dataclass(frozen=True)
class Method(Settings):
    """Settings of a way to identify. Fields marked as parts (`ksmea.settings.part`) are what it is made of: a `surrogate`,
    an `optimizer`, the number of `samples`. A run that uses it ignores the parts that it has not."""

    @classmethod
    def part_names(cls) -> tuple[str, ...]:
        own = {field.name for field in part_fields(cls)}
        return tuple(name for name in METHOD_PARTS if name in own)

    @property
    def ignores(self) -> tuple[str, ...]:
        """Parts of a run that make no difference to it."""
        return tuple(sorted(set(METHOD_PARTS) - set(self.part_names())))

    def validate(self, problem: Problem) -> None:
        """Raise `SettingError` where its parts cannot work together on this problem, before it runs. Left out: they can."""

    @abstractmethod
    def identify(self, problem: Problem, measurement: Measurement, streams: Streams) -> Identification:
        """The values that agree best with the measurement. A problem that is not seen as the measurement is a
        `SettingError`; `ksmea.alignment.aligned` makes the one that is. The problem that an identification hands over
        counts what it is asked and keeps each improvement (`ksmea.trace.TracedProblem`), and its record has both."""
