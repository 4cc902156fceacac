"""Contract of a problem: a rotor with unknowns at given speeds and channels, without true values.

Members that are not abstract have a default, which their docstring states. Parameter vectors are SI, in the order of `parameters`.
Sign convention: a real response is Re(q e^{iΩt}); complex responses q are in m, 0-peak.

Longer than 400 lines: each member of the contract is documented with units and shapes.
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
    """Attribute of a base class that states whether a class overrides a member.

    An object's class then has a member of its own in place of the base class's.

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
    """Rotor with unknowns, evaluated at given speeds and channels. It never knows the true values.

    Attributes or properties of every problem: `parameters`, the unknowns; `speed`, (n_speed,) rad/s; `channels`; `campaign`, the
    runs that its speeds belong to, None for one run without known weights.

    >>> import ksmea
    >>> problem = ksmea.load_problem("three_disk", mesh=13).problem
    >>> x = problem.parameters.to_si(np.full(5, 0.5))
    >>> problem.response(x[None]).shape, problem.sensitivity(x).shape  # (n, n_speed, n_channel), (n_speed, n_channel, d)
    ((1, 53, 2), (53, 2, 5))
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
        """Complex unbalance response at points.

        Args:
            x: values (n, d), SI, in the order of `parameters`.

        Returns:
            Responses (n, n_speed, n_channel), m 0-peak; a real response is Re(q e^{iΩt}).
        """

    def at(self, speed: Array, channels: Sequence[Channel]) -> Problem:
        """Problem evaluated at other speeds and channels.

        Default: not supported.

        Args:
            speed: spin speeds (n_speed,), rad/s.
            channels: probes.

        Raises:
            SettingError: not supported, or a channel lies off the shaft.
        """
        raise self._refusal("can be seen at other speeds and channels", "measure what it has, or give it `at`")

    @property
    def missing(self) -> tuple[str, ...]:
        """Missing parts that a comparison with data needs, but a drawing does not.

        Default: empty.
        """
        return ()

    def remarks_at(self, speed: Array) -> tuple[str, ...]:
        """Sentences for reports on the model at some speeds, such as on a table that ends before them.

        Default: empty.

        Args:
            speed: spin speeds (n,), rad/s.
        """
        return ()

    @property
    def machine(self) -> Problem:
        """Problem that effects act on: itself; of several runs the machine common to all."""
        return self

    def changed(self, change: Callable[[Problem], Problem]) -> Problem:
        """Problem with its machine changed, in all its runs.

        Args:
            change: function from the machine to the changed machine.
        """
        return change(self)

    @property
    def joint(self) -> Problem:
        """Problem with numbers that are known to a tolerance as further unknowns, which have a prior.

        Default: itself, all its numbers are exact.
        """
        return self

    @property
    def as_stated(self) -> Problem:
        """Problem with numbers that are known to a tolerance taken as exact.

        Default: itself.
        """
        return self

    def holding_inputs(self, x: Array) -> Problem | None:
        """Problem whose numbers known to a tolerance have the values of a point, and are no unknowns.

        Default: None, and `ksmea.problem.held` makes one that costs as much as this problem.

        Args:
            x: values (d,), SI.
        """
        return None

    def sensitivity(self, x: Array) -> ComplexArray:
        """Derivatives of the response with respect to the unknowns.

        Default: not supported; differences are used, counted as evaluations.

        Args:
            x: values (d,), SI.

        Returns:
            Derivatives ∂response/∂x, (n_speed, n_channel, d), m per SI unit.
        """
        raise self._refusal(
            "has a sensitivity", "take differences of its response (`ksmea.problem.counted.Model.linearise`)"
        )

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response and sensitivity at a point, together one Jacobian.

        Default: one after the other.

        Args:
            x: values (d,), SI.

        Returns:
            Response (n_speed, n_channel), m, and its derivatives (n_speed, n_channel, d), m per SI unit.
        """
        return self.response(x[None])[0], self.sensitivity(x)

    def linearises_cheaply(self, loads: Sequence[Load] = ()) -> bool:
        """Whether `linearised_per_load` costs no more than a few responses at single points.

        Default: False.

        Args:
            loads: loads on the shaft, as in `linearised_per_load`.
        """
        return False

    @property
    def costly(self) -> Indices:
        """Indices of the unknowns each new value of which costs far more than one of the others.

        Default: empty.
        """
        return np.empty(0, dtype=int)

    @property
    def sites(self) -> Array:
        """Positions along the shaft for a probe or a trial weight, (n,) m.

        Default: empty.
        """
        return np.empty(0)

    @property
    def landmarks(self) -> Mapping[str, float]:
        """Positions (m) of parts along the shaft by their names, for texts and drawings.

        Default: empty.
        """
        return {}

    @property
    def has_free_phase(self) -> bool:
        """Whether the phase of the whole response is unknown.

        Default: True if `phase_origin` is one of its unknowns.
        """
        return PHASE_ORIGIN in self.parameters.names

    def with_phase_origin(self) -> Problem:
        """Problem with an unknown phase of all unbalance; itself if it has one already.

        Default: not supported.

        Raises:
            SettingError: not supported.
        """
        raise self._refusal("can leave the origin of its phases open", "use the amplitudes alone")

    def with_unbalance(self, position: float, magnitude: float, phase: float) -> Problem:
        """Problem with a known unbalance added.

        Default: not supported.

        Args:
            position: position on the shaft, m.
            magnitude: unbalance, kg m.
            phase: angle, rad.

        Raises:
            SettingError: not supported.
        """
        raise self._refusal("takes a trial unbalance", "leave the trial run out")

    def with_unknown_unbalance(self, position: float, names: tuple[str, str], at_most: float) -> Problem:
        """Problem with an unknown unbalance added: two further unknowns.

        Default: not supported.

        Args:
            position: position on the shaft, m.
            names: names of the unknowns, the components at 0° and 90°.
            at_most: limit of each component to either side of 0, kg m.

        Raises:
            SettingError: not supported.
        """
        raise self._refusal("takes an unknown weight", "give the weight's g_mm")

    def going(self, run: Run) -> Problem:
        """Problem with the speed history of one run of a campaign.

        Default: unchanged.

        Args:
            run: run of a campaign.
        """
        return self

    def next_to(self, motion: ComplexArray) -> Problem:
        """Problem that takes, of several steady-state responses, the one nearest to a given motion.

        Default: unchanged, it has one.

        Args:
            motion: motion (n_speed, 2) at 1X, m, of the site of its nonlinear force.
        """
        return self

    def unbalance(self, x: Array) -> Mapping[float, complex]:
        """Unbalance by position.

        Default: empty.

        Args:
            x: values (d,), SI.

        Returns:
            Complex unbalance, kg m, by position, m; angles as in `with_unbalance`.
        """
        return {}

    @property
    def unknown_impedances(self) -> tuple[UnknownImpedance, ...]:
        """Unknown impedances, if its response is linear and determined by these and `unbalance`.

        Default: empty.
        """
        return ()

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        """Response to unit loads at 1X.

        Default: not supported.

        Args:
            x: values (n, d), SI.
            loads: unit forces or moments on the shaft.

        Returns:
            Responses (n, n_speed, n_channel, n_load), m per N or N m.

        Raises:
            SettingError: not supported.
        """
        raise self._refusal("takes loads on its shaft", "take one that is made of a rotor")

    def response_and_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        """Results of `response` and `load_response` at common points, which one solution may give.

        Args:
            x: values (n, d), SI.
            loads: unit forces or moments on the shaft.
        """
        return self.response(x), self.load_response(x, loads)

    def linearised_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        """Columns of `response` and then `load_response` at a point, with their derivatives.

        Default: central differences of both; without loads the result of `linearised`.

        Args:
            x: values (d,), SI.
            loads: unit forces or moments on the shaft.

        Returns:
            Columns (n_speed, n_channel, 1 + n_load), and their derivatives (n_speed, n_channel, 1 + n_load, d) per SI unit.
        """
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
        """Response by a second, slower route, for comparison and for making data.

        Default: not supported.

        Args:
            x: values (n, d), SI.

        Returns:
            Responses (n, n_speed, n_channel), m 0-peak.

        Raises:
            SettingError: not supported.
        """
        raise self._refusal("has a dense route", "give measurement.route=reduced")

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        """Speeds at which a damped natural frequency equals the spin speed.

        Default: not supported.

        Args:
            x: values (d,), SI.
            highest: highest speed, rad/s. Default: its own highest speed.

        Returns:
            Rising speeds (n,), rad/s.

        Raises:
            SettingError: not supported.
        """
        raise self._knows_no_modes()

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        """Damped natural modes at a spin speed.

        Default: not supported.

        Args:
            x: values (d,), SI.
            speed: spin speed, rad/s.
            n_mode: number of modes. Default: all.

        Raises:
            SettingError: not supported.
        """
        raise self._knows_no_modes()

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        """Natural frequencies and damping ratios of the first modes over spin speed.

        Default: not supported.

        Args:
            x: values (d,), SI.
            speed: spin speeds (n_speed,), rad/s.
            n_mode: number of modes.

        Raises:
            SettingError: not supported.
        """
        raise self._knows_no_modes()

    def growth_rate(self, x: Array, speed: Array) -> Array:
        """Largest real part of any damped eigenvalue at each spin speed.

        Above 0 a free vibration grows, and no steady-state response exists. Default: not supported.

        Args:
            x: values (d,), SI.
            speed: spin speeds (n_speed,), rad/s.

        Returns:
            Growth rates (n_speed,), 1/s.

        Raises:
            SettingError: not supported.
        """
        raise self._refusal("knows its damped eigenvalues", "take one that is made of a rotor")

    def stability_threshold(self, x: Array, highest: float) -> float:
        """Lowest spin speed at which a free vibration grows.

        Args:
            x: values (d,), SI.
            highest: highest speed that is checked, rad/s.

        Returns:
            Speed, rad/s; 0 if it grows from rest, infinite if it grows nowhere.

        Raises:
            SettingError: `growth_rate` is not supported.
        """
        return lowest_unstable_speed(lambda speed: self.growth_rate(x, speed), highest)

    def is_stable(self, x: Array) -> bool:
        """Whether no free vibration grows at any spin speed up to its highest, as far as it can tell.

        Args:
            x: values (d,), SI.
        """
        return not self.knows_stability or grows_nowhere(lambda at: self.growth_rate(x, at), float(np.max(self.speed)))

    def _knows_no_modes(self) -> SettingError:
        return self._refusal("knows its natural modes", "take one that is made of a rotor")

    def _refusal(self, what: str, try_this: str) -> SettingError:
        return SettingError(f"expected a problem that {what}, got {type(self).__name__}; {try_this}")


def joint_values(problem: Problem, joint: Problem, x: Array, numbers: Mapping[str, float] | None = None) -> Array:
    """Values of the unknowns of a problem's `joint`; all others are as stated.

    Args:
        problem: problem with numbers known to a tolerance.
        joint: its `joint`.
        x: values (d,) of the problem's own unknowns, SI.
        numbers: values of further unknowns by name, SI.

    Returns:
        Values of the unknowns of `joint`, SI.
    """
    known = {**(numbers or {}), **dict(zip(problem.parameters.names, x))}
    return np.array([known.get(item.name, item.stated) for item in joint.parameters])
