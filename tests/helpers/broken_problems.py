"""Problem and effect that keep every property of their exams.

For each property there is one that breaks it.
"""

from dataclasses import dataclass, replace

import numpy as np

from ksmea import Effect
from ksmea.errors import SettingError
from ksmea.problem.forwarding import ProblemProxy
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.settings.settings import setting
from ksmea.testing.jeffcott import Jeffcott, JeffcottRotor
from ksmea.units import MICROMETRE


@dataclass(frozen=True)
class Whole(Jeffcott):
    """The rotor of the exam with all that a problem may have."""

    parameters: Parameters = Jeffcott.parameters

    def growth_rate(self, x, speed):
        return np.full(np.shape(speed), -1.0)

    def dense_response(self, x):
        return self.response(x)

    def with_phase_origin(self):
        return replace(self, parameters=with_origin("phase_origin"))

    def response(self, x):
        origin = x[:, 5, None, None] if x.shape[1] > 5 else 0.0
        return np.exp(1j * origin) * super().response(x)


def with_origin(name):
    return Parameters((*Jeffcott.parameters, Parameter(name, "rad", 1.0, -np.pi, np.pi)))


FIRST, *OTHERS = Jeffcott.parameters
TAKEN_FOR_NEWTONS = Parameters((replace(FIRST, si_per_unit=1.0), *OTHERS))


@dataclass(frozen=True)
class InNewtons(Whole):
    """Limits in MN/m that are taken for N/m."""

    parameters: Parameters = TAKEN_FOR_NEWTONS


class Amplitude(Whole):
    def response(self, x):
        return np.abs(super().response(x))


class FirstOfBatch(Whole):
    def response(self, x):
        return super().response(x) * x[:1, 4, None, None] / x[:, 4, None, None]


class WrongSign(Whole):
    def sensitivity(self, x):
        return super().sensitivity(x) * np.array([1, 1, -1, 1, 1])


class BySpeedOrder(Whole):
    def response(self, x):
        return super().response(x) * np.arange(1, len(self.speed) + 1)[:, None]

    has_sensitivity = False


class TwoRoutes(Whole):
    def dense_response(self, x):
        return np.conj(self.response(x))


class UnnamedOrigin(Whole):
    def with_phase_origin(self):
        return replace(self, parameters=with_origin("origin"))


class OneGrowth(Whole):
    def growth_rate(self, x, speed):
        return -1.0 if np.ndim(speed) and len(speed) == 3 else np.full(np.shape(speed), -1.0)


class Growing(Whole):
    def growth_rate(self, x, speed):
        return np.asarray(speed) - 300.0


class Narrow(Whole):
    def response(self, x):
        with np.errstate(divide="ignore", invalid="ignore"):
            return super().response(x) / (x[:, 4, None, None] > 100.0001e-6)


class Massive(Jeffcott):
    mass = 10.0  # kg


@dataclass(frozen=True)
class Rotor(JeffcottRotor):
    """A rotor of one of these problems."""

    problem: str = setting("Whole", "its class in this module")

    def build(self):
        if self.problem not in globals():
            raise SettingError(f"problem: expected one of this module, got {self.problem!r}; look for it")
        return globals()[self.problem](speed=np.linspace(100.0, 500.0, self.n_speed))


@dataclass(frozen=True)
class InUnits(Rotor):
    """It publishes values in the units of its parameters."""

    def reference(self):
        return {"kxx": 0.9}


@dataclass(frozen=True)
class Drawn(Rotor):
    """Its speeds are drawn when it is built."""

    def build(self):
        return replace(super().build(), speed=np.linspace(100.0, 500.0, 9) + np.random.default_rng().random())


BROKEN_PROBLEMS = [
    ("gives_a_problem", Rotor(problem="Lost"), "got SettingError: problem: expected one of this module, got 'Lost'"),
    ("unknowns_have_units", Rotor(problem="InNewtons"), r"si_per_unit = 1e\+06 of kxx, which is in MN/m, got 1; take"),
    ("responds_in_shape", Rotor(problem="Amplitude"), r"complex responses, got float64; keep the phase"),
    (
        "batch_equals_single",
        Rotor(problem="FirstOfBatch"),
        r"the same responses one by one, got others by .*; treat rows",
    ),
    (
        "sensitivity_is_right",
        Rotor(problem="WrongSign"),
        r"∂response/∂cxx as differences have it, got .* off by 2 .*sign",
    ),
    ("is_the_same_elsewhere", Rotor(problem="BySpeedOrder"), r"responses at fewer speeds and channels, got others by"),
    ("routes_agree", Rotor(problem="TwoRoutes"), r"the same by both routes, got others by .*; mend one of them"),
    (
        "phase_origin_zero_is_known",
        Rotor(problem="UnnamedOrigin"),
        r"phase_origin as one more unknown, got .*, origin;",
    ),
    (
        "growth_rates_are_in_shape",
        Rotor(problem="OneGrowth"),
        r"3 growth rates, 1/s, got .*; take the largest real part",
    ),
    (
        "published_machine_is_stable",
        Rotor(problem="Growing"),
        r"growth rates below 0 .*, got growth from 300.* rad/s on",
    ),
    ("responds_at_its_limits", Rotor(problem="Narrow"), r"finite responses at the limits, got NaN or infinity; narrow"),
    ("published_values_are_between_the_limits", InUnits(), r"from 600000 to 1.4e\+06 SI, got 0.9; .* times 1e\+06 if"),
    ("builds_the_same_again", Drawn(), r"the same response, got another; draw and keep nothing in build"),
]


OFFSET = Parameter("offset", "µm", MICROMETRE, -1e-4, 1e-4)


class Offset(ProblemProxy):
    """A problem whose responses are all shifted by the last unknown."""

    behind = None  # given by each

    def __init__(self, behind, unknown=OFFSET):
        self.behind, self.unknown = behind, unknown

    @property
    def parameters(self):
        return Parameters((*self.behind.parameters, self.unknown))

    def around(self, behind):
        return type(self)(behind, self.unknown)

    def response(self, x):
        return self.behind.response(x[:, :-1]) + x[:, -1, None, None]

    def sensitivity(self, x):
        own = self.behind.sensitivity(x[:-1])
        return np.concatenate([own, np.ones((*own.shape[:2], 1))], axis=-1)


@dataclass(frozen=True)
class Shift(Effect):
    """All responses are shifted alike."""

    sites: tuple[str, ...] = setting((), "where it may be")

    def locations(self, problem):
        return (self, self) if self.sites else (self,)

    def parameters(self, problem):
        return (OFFSET,)

    def added_to(self, problem):
        if not isinstance(problem, Jeffcott):
            raise SettingError(f"expected a Jeffcott rotor, got {type(problem).__name__}; take one")
        return Offset(problem)

    def draw(self, problem, rng):
        return rng.uniform(1e-6, 1e-5, 1)


@dataclass(frozen=True)
class FromOne(Shift):
    """It is never 0."""

    def added_to(self, problem):
        return Offset(problem, replace(OFFSET, lower=1e-6))


class ByOne(Offset):
    def response(self, x):
        return super().response(x) * 1.01


class Idle(Offset):
    def response(self, x):
        return self.behind.response(x[:, :-1])


@dataclass(frozen=True)
class NotAtZero(Shift):
    """It changes the response also at 0."""

    def added_to(self, problem):
        return ByOne(problem)


@dataclass(frozen=True)
class WithoutEffect(Shift):
    """It changes nothing."""

    def added_to(self, problem):
        return Idle(problem)


@dataclass(frozen=True)
class DrawsMicrometres(Shift):
    """It draws in micrometres."""

    def draw(self, problem, rng):
        return rng.uniform(1, 10, 1)


@dataclass(frozen=True)
class OfMass(Shift):
    """It takes any problem for a rotor with a mass."""

    def added_to(self, problem):
        return Offset(problem) if problem.mass else problem


BROKEN_EFFECTS = [
    (
        "sites_have_names",
        Shift(sites=["left", "right"]),
        r"a name of its own for each site, got .*; say where in __str__",
    ),
    (
        "unknowns_follow_and_hold_zero",
        FromOne(),
        r"limits of offset around 0, got \[1e-06, 0.0001\]; measure from none",
    ),
    ("zero_is_the_baseline", NotAtZero(), r"the baseline's response at 0 .*, got another by 0.0\d+; let 0 be none"),
    (
        "draws_within_its_limits",
        DrawsMicrometres(),
        r"draws within the limits, SI .*; narrow them, or widen the limits",
    ),
    ("what_is_drawn_matters", WithoutEffect(), r"another response .*, got a change by 0; use its unknowns"),
    ("another_problem_is_refused", OfMass(), r"of another kind, got AttributeError: .*; check it with isinstance in"),
]
