"""Contract of a problem: a rotor with unknowns, evaluated at given speeds and channels, without the true values.

Members that are not abstract have a default, which their docstring states. Parameter vectors are SI, in the order of `parameters`.
Sign convention: a real response is Re(q e^{iΩt}); complex responses q are in m, 0-peak.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.errors import SettingError
from ksmea.measurement.campaign import Campaign, Run
from ksmea.measurement.channel import Channel
from ksmea.numerics.differences import CUBE_STEP, differenced
from ksmea.problem.load import Load
from ksmea.problem.parameters import PHASE_ORIGIN, Parameters
from ksmea.problem.response_structure import UnknownImpedance
from ksmea.rotordynamics.stability import grows_nowhere, lowest_unstable_speed
from ksmea.rotordynamics.whirl import Campbell, Mode


class Given:
    """An attribute of a base class: whether the class of an object has a member of its own in place of the base class's.

    >>> class Shape:
    ...     def area(self): raise NotImplementedError
    ...     has_area = Given("area")
    >>> class Square(Shape):
    ...     def area(self): return 1
    >>> Shape().has_area, Square().has_area
    (False, True)
    """

    def __init__(self, member: str) -> None:
        self._member = member

    def __set_name__(self, base: type, name: str) -> None:
        self._base = base

    def __get__(self, instance: object, owner: type) -> bool:
        return getattr(owner, self._member) is not getattr(self._base, self._member)


class Problem(ABC):
    """A rotor with unknowns, seen at given speeds through given channels. It never knows the true values.

    Attributes or properties of every problem: `parameters`, the unknowns; `speed`, (n_speed,) rad/s; `channels`; `campaign`, the
    runs that its speeds belong to, None for one run without known weights.
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
        """The rotor evaluated at other speeds (rad/s) and channels. Default: not supported."""
        raise self._refusal("can be seen at other speeds and channels", "measure what it has, or give it `at`")

    @property
    def missing(self) -> tuple[str, ...]:
        """Missing parts that a comparison with data needs, but a drawing does not. Default: empty."""
        return ()

    def remarks_at(self, speed: Array) -> tuple[str, ...]:
        """Sentences for reports on the model at speeds (n,) rad/s, such as of a table that ends before them; by default none."""
        return ()

    @property
    def machine(self) -> Problem:
        """The problem that effects act on: itself; of several runs the machine common to all."""
        return self

    def changed(self, change: Callable[[Problem], Problem]) -> Problem:
        """The problem with its machine changed, in all its runs."""
        return change(self)

    @property
    def joint(self) -> Problem:
        """The problem with numbers that are known to a tolerance as further unknowns, which have a prior. Default: itself, all its
        numbers are exact."""
        return self

    @property
    def as_stated(self) -> Problem:
        """The problem with these numbers exact. Default: itself."""
        return self

    def sensitivity(self, x: Array) -> ComplexArray:
        """(d,) SI → ∂response/∂x, (n_speed, n_channel, d), m per SI unit. Default: differences, counted as evaluations."""
        raise self._refusal(
            "has a sensitivity", "take differences of its response (`ksmea.problem.counted.Model.linearise`)"
        )

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response (n_speed, n_channel) and sensitivity at x (d,) SI, together one Jacobian. Default: one after the other."""
        return self.response(x[None])[0], self.sensitivity(x)

    def linearises_cheaply(self, loads: Sequence[Load] = ()) -> bool:
        """Whether `linearised_per_load` costs no more than a few responses at single points. Default: False."""
        return False

    @property
    def costly(self) -> Indices:
        """Indices of the unknowns each new value of which costs far more than one of the others. Default: empty."""
        return np.empty(0, dtype=int)

    @property
    def sites(self) -> Array:
        """Positions along the shaft for a probe or a trial weight, (n,) m. Default: empty."""
        return np.empty(0)

    @property
    def landmarks(self) -> Mapping[str, float]:
        """Positions (m) of parts along the shaft by their names, for texts and drawings. Default: empty."""
        return {}

    @property
    def has_free_phase(self) -> bool:
        """Whether the phase of the whole response is unknown. Default: True if `phase_origin` is one of its unknowns."""
        return PHASE_ORIGIN in self.parameters.names

    def with_phase_origin(self) -> Problem:
        """The rotor with the phase of all unbalance unknown; itself if it is already. Default: not supported."""
        raise self._refusal("can leave the origin of its phases open", "use the amplitudes alone")

    def with_unbalance(self, position: float, magnitude: float, phase: float) -> Problem:
        """The rotor with a known unbalance (kg m, rad) added at a position (m). Default: not supported."""
        raise self._refusal("takes a trial unbalance", "leave the trial run out")

    def with_unknown_unbalance(self, position: float, names: tuple[str, str], at_most: float) -> Problem:
        """The rotor with an unknown unbalance added at a position (m): two unknowns of these names, its components at 0° and
        90° within ± `at_most` (kg m). Default: not supported."""
        raise self._refusal("takes an unknown weight", "give the weight's g_mm")

    def going(self, run: Run) -> Problem:
        """The problem as the speed goes in one run of a campaign. Default: unchanged."""
        return self

    def next_to(self, motion: ComplexArray) -> Problem:
        """The problem that takes, of several steady motions, the one nearest to a motion (n_speed, 2), m at 1X, of the site of its
        nonlinear force. Default: unchanged, it has one."""
        return self

    def unbalance(self, x: Array) -> Mapping[float, complex]:
        """Its unbalance at x (d,) SI by position (m), kg m, angles as of `with_unbalance`. Default: empty."""
        return {}

    @property
    def unknown_impedances(self) -> tuple[UnknownImpedance, ...]:
        """Its unknown impedances, if its response is linear and made by these and `unbalance`. Default: empty."""
        return ()

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        """Response to unit loads at 1X, (n, d) SI → (n, n_speed, n_channel, n_load) m per N or N m. Default: not supported."""
        raise self._refusal("takes loads on its shaft", "take one that is made of a rotor")

    def response_and_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        """`response` and `load_response` at the same points, which a problem may know by one solution."""
        return self.response(x), self.load_response(x, loads)

    def linearised_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        """`response` and then `load_response` at x (d,) SI as columns (n_speed, n_channel, 1 + n_load), and their derivatives
        (…, d) per SI unit. Default: by central differences of both, or without loads as `linearised` has them."""
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
        """`response` by a second, slower route, for comparison and for making data. Default: not supported."""
        raise self._refusal("has a dense route", "give measurement.route=reduced")

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        """Speeds (rad/s) up to `highest` at which a damped natural frequency equals the spin speed, rising, at values
        x (d,) SI; None: up to its own highest speed. Default: not supported."""
        raise self._knows_no_modes()

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        """Its damped natural modes at x (d,) SI and a spin speed (rad/s), the first `n_mode` or all. Default: not supported."""
        raise self._knows_no_modes()

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        """Natural frequencies and damping ratios of its first modes over spin speeds (n_speed,) rad/s. Default: not supported."""
        raise self._knows_no_modes()

    def growth_rate(self, x: Array, speed: Array) -> Array:
        """The largest real part of any damped eigenvalue (1/s) at values x (d,) SI and each spin speed (n_speed,) rad/s:
        above 0 a free motion grows, and no steady response exists. Default: not supported."""
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


def joint_values(problem: Problem, joint: Problem, x: Array, numbers: Mapping[str, float] | None = None) -> Array:
    """Values (d,) SI of the unknowns of a problem's `joint`: x (d,) of the problem's own ones, `numbers` by name, all others as
    stated."""
    known = {**(numbers or {}), **dict(zip(problem.parameters.names, x))}
    return np.array([known.get(item.name, item.stated) for item in joint.parameters])
