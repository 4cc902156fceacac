"""The contracts between the framework and what is plugged into it; small enough to read at one sitting.

A plugin is one file: a frozen dataclass whose fields are its settings (`ksmea.settings.Settings`), and one entry
point in `ksmea.problems`, `ksmea.surrogates`, `ksmea.optimizers` or `ksmea.methods`. Points are rows of the unit
cube, (n, d) in [0, 1]; physical parameter vectors are SI, in the order of `Problem.parameters`.

Sign convention: a real response is Re(q e^{iΩt}); complex responses q are in m, 0-peak.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.parameters import Parameter, Parameters

if TYPE_CHECKING:
    from ksmea.model import Model
    from ksmea.objective import Minimum, Objective

ComplexArray = NDArray[np.complex128]

PHASE_ORIGIN = "phase_origin"  # name of the unknown that measured phases bring along: it turns all data alike


@dataclass(frozen=True)
class Channel:
    """One probe: where along the shaft it looks (m) and in which direction."""

    position: float
    direction: str

    def __post_init__(self) -> None:
        if self.direction not in ("x", "y"):
            raise SettingError(f"direction of a channel: expected x or y, got {self.direction!r}")

    def __str__(self) -> str:
        return f"{self.direction} at {self.position:g} m"


class Problem(Protocol):
    """A rotor with unknowns, seen at given speeds through given channels. It never knows the true values."""

    @property
    def parameters(self) -> Parameters: ...

    @property
    def speed(self) -> Array:  # (n_speed,) rad/s
        ...

    @property
    def channels(self) -> tuple[Channel, ...]: ...

    def response(self, x: Array) -> ComplexArray:
        """(n, d) SI → (n, n_speed, n_channel), m."""
        ...

    def sensitivity(self, x: Array) -> ComplexArray:
        """(d,) SI → ∂response/∂x, (n_speed, n_channel, d), m per SI unit. A problem may leave it out: differences
        of the response take its place, counted as evaluations."""
        ...

    @property
    def costly(self) -> Array:
        """Places of the unknowns each new value of which costs far more than one of the others. A problem may leave it
        out: none are."""
        ...

    def at(self, speed: Array, channels: Sequence[Channel]) -> Problem:
        """The same rotor at other speeds (rad/s) and channels."""
        ...

    @property
    def sites(self) -> Array:
        """Where along the shaft a probe could look or a trial weight could sit, (n,) m. A problem may leave it out:
        other sensor positions are not considered then."""
        ...

    def with_phase_origin(self) -> Problem:
        """The same rotor with the phase of all unbalance unknown, as measured phases have it; itself where it is so
        already. A problem may leave it out: it has no use for measured phases then."""
        ...

    def with_unbalance(self, position: float, magnitude: float, phase: float) -> Problem:
        """The same rotor with a known unbalance (kg m, rad) added at a position (m): a trial run. A problem may leave
        it out."""
        ...


class Effect(Protocol):
    """A physical cause that a model may lack, at one place; what registers under `ksmea.effects` is such an effect with
    its default place. How it changes a response is between it and the problems that know effects of its kind."""

    @property
    def aliases(self) -> Mapping[str, str]:
        """Effects that can look alike, by name, and what separates them."""
        ...

    @property
    def is_scanned(self) -> bool:
        """Whether fits have to be sought all over its bounds, not only from where the model without it fits: of effects that
        move resonances, or hide them."""
        ...

    def places(self, problem: Problem) -> Sequence[Effect]:
        """This effect at each place of the problem where it may sit; none where it cannot be."""
        ...

    def parameters(self, problem: Problem) -> tuple[Parameter, ...]:
        """Its unknowns with physical bounds. At 0 of all of them the model is as without it."""
        ...

    def added_to(self, problem: Problem) -> Problem:
        """The problem with this effect, whose unknowns follow its own: a problem like any other."""
        ...

    def draw(self, problem: Problem, rng: np.random.Generator) -> Array:
        """Values (e,) SI of its unknowns that are plausible and large enough to be noticed, for data that hide it."""
        ...


class ProblemSettings(Protocol):
    """What registers under `ksmea.problems`: settings that build a problem, and the published values of its unknowns.

    They are apart so that what is handed to an identification cannot hold the values it is to find. Settings that
    name a file have a `fingerprint() -> str` of its content, which belongs to what a result is computed from; so do
    those of a measurement.
    """

    def build(self) -> Problem: ...

    def reference(self) -> Mapping[str, float]:
        """Published values by parameter name, SI; only what makes synthetic data and prints tables may read them."""
        ...


class Predictor(Protocol):
    """A fitted surrogate. These further members are used where a predictor has them:

    - `variance(u) -> (k, q)`: prediction variance of each output;
    - `leave_one_out() -> (q,)`: rms leave-one-out error of each output;
    - `append(u (d,), y (q,)) -> Predictor`: a new predictor with one more sample, cheaper than a new fit;
    - `notes: Mapping[str, float]`: what is worth a place in the run's record (a nugget that grew, θ …).
    """

    def predict(self, u: Array) -> Array:
        """(k, d) → (k, q)."""
        ...


@runtime_checkable
class Surrogate(Protocol):
    """Settings of a surrogate. `transform` names how the real outputs are made of the complex response
    (`ksmea.transforms.TRANSFORMS`, or 'auto'): a setting where the user may choose, else a class constant."""

    transform: str

    def least_samples(self, d: int) -> int:
        """The fewest samples it can be fitted to in d dimensions."""
        ...

    def fit(self, u: Array, y: Array, model: Model, rng: np.random.Generator) -> Predictor:
        """Samples u (n, d) in the unit cube with outputs y (n, q); `model` is the counted true model.

        Where a surrogate has `refit(previous, u, y, model, rng)`, a fit that starts from an earlier predictor, the
        loop calls that at its updates.
        """
        ...


@runtime_checkable
class Optimizer(Protocol):
    """Settings of an optimiser. It asks the objective for values and returns `objective.result()`;
    it lets `BudgetSpent` pass. Where it does not suit every number of unknowns it has a
    `check_dimension(dim)` that raises `SettingError`."""

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum: ...
