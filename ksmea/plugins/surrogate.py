"""Contract of a surrogate: settings that are fitted to samples, and the predictor that results.

A plugin is one file: a frozen dataclass whose fields are its settings, which subclasses a contract, and one entry point.
`ksmea.plugins.registry` rejects a class that does not. Members that are not abstract have a default, which their docstring states.
Points are rows of the unit cube, (n, d) in [0, 1].
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import warn_renamed
from ksmea.problem.response_structure import ResponseStructure
from ksmea.settings.settings import Settings


@dataclass(frozen=True)
class Surrogate(Settings):
    """Settings of a surrogate. `transform` names how the real outputs are made of the complex response
    (`ksmea.plugins.transforms.TRANSFORMS`): a setting where the user may choose, else a class constant; left out: 'auto'."""

    transform = "auto"
    is_true_model: ClassVar[bool] = False  # whether a method evaluates the true model in its place and fits nothing

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        if "told_of" in vars(cls):
            warn_renamed(f"{cls.__name__}.told_of", "with_structure")

    def with_structure(self, structure: ResponseStructure) -> Surrogate:
        """This surrogate for a problem whose response has a known structure. Default: the surrogate itself, which does not use it."""
        return self.told_of(structure)

    def told_of(self, structure: ResponseStructure) -> Surrogate:
        """Earlier name of `with_structure`, which plugins may override or call for one more release."""
        is_overridden = type(self).with_structure is not Surrogate.with_structure
        return self.with_structure(structure) if is_overridden else self

    @abstractmethod
    def least_samples(self, d: int) -> int:
        """The fewest samples it can be fitted to in d dimensions."""

    @abstractmethod
    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        """A predictor from samples u (n, d) in the unit cube with outputs y (n, q); or `ksmea.plugins.surrogate.Unsuited`."""

    def refit(self, previous: Predictor, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        """`fit` that may start from an earlier predictor of fewer samples. Default: `fit`."""
        return self.fit(u, y, rng)


class Predictor(ABC):
    """A fitted surrogate."""

    @abstractmethod
    def predict(self, u: Array) -> Array:
        """(k, d) → (k, q)."""

    def variance(self, u: Array) -> Array | None:
        """Prediction variance of each output, (k, q). Default: None, it is not known."""
        return None

    def leave_one_out(self) -> Array | None:
        """Root mean square leave-one-out error of each output, (q,). Default: None, the prediction counts as exact."""
        return None

    def append(self, u: Array, y: Array) -> Predictor | None:
        """A new predictor with one more sample u (d,), y (q,), cheaper than a new fit. Default: None, fit anew."""
        return None

    @property
    def notes(self) -> Mapping[str, float]:
        """What is worth keeping in the run's record (a nugget that grew, θ …). Default: nothing."""
        return {}


class Unsuited(ArithmeticError):
    """Raised by the fit of a surrogate where samples show that it cannot follow the response: `substitute` takes over; None: the
    run ends with the message."""

    def __init__(self, message: str, substitute: Surrogate | None = None) -> None:
        super().__init__(message)
        self.substitute = substitute
