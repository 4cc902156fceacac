"""A surrogate whose predictions are counted by who runs a method, not by the method."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass
from types import MethodType
from typing import Any, TypeVar

import numpy as np

from ksmea.arrays import Array
from ksmea.contracts import Surrogate
from ksmea.predictor import Predictor
from ksmea.unsuited import Unsuited

AnyMethod = TypeVar("AnyMethod")


@dataclass
class PredictionCount:
    """Points that surrogates have predicted."""

    points: int = 0


def with_counted_surrogate(method: AnyMethod, count: PredictionCount) -> AnyMethod:
    """The same method, its surrogate counted; as it is where it has none, or one that is the true model."""
    surrogate = getattr(method, "surrogate", None)
    if not isinstance(surrogate, Surrogate) or surrogate.is_true_model:
        return method
    counted = copy.copy(method)
    object.__setattr__(counted, "surrogate", CountedSurrogate(surrogate, count))  # settings are frozen
    return counted


class CountedPredictor(Predictor):
    """A predictor that counts the points it predicts. Whatever else it is asked, the one behind answers."""

    def __init__(self, behind: Predictor, count: PredictionCount) -> None:
        self.behind = behind
        self.count = count

    def predict(self, u: Array) -> Array:
        self.count.points += len(u)
        return self.behind.predict(u)

    def append(self, u: Array, y: Array) -> Predictor | None:
        appended = self.behind.append(u, y)
        return None if appended is None else CountedPredictor(appended, self.count)

    def __getattr__(self, name: str) -> Any:
        return _behind(self, name)


@dataclass(frozen=True)
class CountedSurrogate(Surrogate):
    """A surrogate whose predictors count. Whatever else it is asked, the one behind answers."""

    behind: Surrogate
    count: PredictionCount

    def least_samples(self, d: int) -> int:
        return self.behind.least_samples(d)

    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        return self._counted(lambda: self.behind.fit(u, y, rng))

    def refit(self, previous: Predictor, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        bare = previous.behind if isinstance(previous, CountedPredictor) else previous
        return self._counted(lambda: self.behind.refit(bare, u, y, rng))

    def _counted(self, made: Callable[[], Predictor]) -> CountedPredictor:
        """A predictor that counts; so does what takes over where the surrogate is not suited."""
        try:
            return CountedPredictor(made(), self.count)
        except Unsuited as unsuited:
            if unsuited.substitute is not None and not unsuited.substitute.is_true_model:
                unsuited.substitute = CountedSurrogate(unsuited.substitute, self.count)
            raise

    def __getattr__(self, name: str) -> Any:
        return _behind(self, name)


def _behind(counted: Any, name: str) -> Any:
    """An attribute of what is counted, which a copy in the making does not have yet; a surrogate that a method of it returns is
    counted too."""
    if name in ("behind", "count") or name.startswith("__"):
        raise AttributeError(name)
    member = getattr(counted.behind, name)
    if not isinstance(member, MethodType):
        return member

    def call(*arguments: Any, **named: Any) -> Any:
        answer = member(*arguments, **named)
        return CountedSurrogate(answer, counted.count) if isinstance(answer, Surrogate) else answer

    return call


def _handed_on(name: str) -> property:
    return property(lambda self: _behind(self, name))


# What the contracts have a default for is asked of the one behind too.
for _counted, _contract in ((CountedPredictor, Predictor), (CountedSurrogate, Surrogate)):
    for _name in set(vars(_contract)) - set(vars(_counted)):
        if not _name.startswith("_"):
            setattr(_counted, _name, _handed_on(_name))
