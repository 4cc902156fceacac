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
    """Settings of a surrogate.

    `transform` names how the real outputs are made of the complex response (`ksmea.plugins.transforms.TRANSFORMS`). It is a setting
    if the user may choose, otherwise a class constant. Default: 'auto'.

    >>> from ksmea.plugins import registry
    >>> surface = registry.create("surrogate", "rsm", {})
    >>> u = np.random.default_rng(0).random((20, 2))
    >>> fitted = surface.fit(u, u.sum(axis=1, keepdims=True), np.random.default_rng(1))
    >>> surface.least_samples(2) <= 20, fitted.predict(np.array([[0.25, 0.5]])).round(6).tolist()
    (True, [[0.75]])
    """

    transform = "auto"
    is_true_model: ClassVar[bool] = False  # whether a method evaluates the true model in its place and fits nothing

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        if "told_of" in vars(cls):
            warn_renamed(f"{cls.__name__}.told_of", "with_structure")

    def with_structure(self, structure: ResponseStructure) -> Surrogate:
        """This surrogate for a problem whose response has a known structure.

        Default: the surrogate itself, which does not use it.

        Args:
            structure: unknown impedances and unbalance that determine the response.
        """
        return self.told_of(structure)

    def told_of(self, structure: ResponseStructure) -> Surrogate:
        """Earlier name of `with_structure`, which plugins may override or call for one more release.

        Args:
            structure: as in `with_structure`.
        """
        is_overridden = type(self).with_structure is not Surrogate.with_structure
        return self.with_structure(structure) if is_overridden else self

    @abstractmethod
    def least_samples(self, d: int) -> int:
        """Smallest number of samples it can be fitted to.

        Args:
            d: number of unknowns.
        """

    @abstractmethod
    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        """Fit a predictor to samples.

        Args:
            u: samples (n, d) in the unit cube.
            y: real outputs (n, q) of the transformed response.
            rng: the only source of random numbers.

        Returns:
            Fitted surrogate.

        Raises:
            Unsuited: the samples show that it cannot follow the response.
        """

    def refit(self, previous: Predictor, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        """Fit that may start from an earlier predictor of fewer samples.

        Default: `fit`.

        Args:
            previous: predictor fitted to fewer of these samples.
            u: samples (n, d) in the unit cube.
            y: real outputs (n, q).
            rng: the only source of random numbers.

        Returns:
            Fitted surrogate.

        Raises:
            Unsuited: as in `fit`.
        """
        return self.fit(u, y, rng)


class Predictor(ABC):
    """A fitted surrogate."""

    @abstractmethod
    def predict(self, u: Array) -> Array:
        """Predict outputs.

        Args:
            u: points (k, d) in the unit cube.

        Returns:
            Outputs (k, q).
        """

    def variance(self, u: Array) -> Array | None:
        """Prediction variance of each output.

        Default: None, not known.

        Args:
            u: points (k, d) in the unit cube.

        Returns:
            Variances (k, q), in squared units of the outputs.
        """
        return None

    def leave_one_out(self) -> Array | None:
        """Root mean square leave-one-out error of each output, (q,).

        Default: None, exact.
        """
        return None

    def append(self, u: Array, y: Array) -> Predictor | None:
        """New predictor with one more sample, cheaper than a new fit.

        Default: None, fit again.

        Args:
            u: sample (d,) in the unit cube.
            y: its outputs (q,).
        """
        return None

    @property
    def notes(self) -> Mapping[str, float]:
        """Notes for the run's record, such as a nugget that grew or θ.

        Default: empty.
        """
        return {}


class Unsuited(ArithmeticError):
    """Raised by the fit of a surrogate if samples show that it cannot follow the response.

    Args:
        message: what the samples show.
        substitute: surrogate that is used in its place. Default: None, the run ends with the message.
    """

    def __init__(self, message: str, substitute: Surrogate | None = None) -> None:
        super().__init__(message)
        self.substitute = substitute
