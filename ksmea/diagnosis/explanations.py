"""Explanations of data: one effect or two that extend the baseline model, and which of them come as near as the best.

Two explanations cannot be told apart where one is within ΔBIC ≤ 6 of the other (Kass & Raftery 1995), or where its deviance
is as low: what BIC charges for further unknowns is no evidence in the data.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.diagnosis.fitting import Fit
from ksmea.diagnosis.trials import Candidate, Trial

NEAR = 6.0  # ΔBIC within which effects cannot be told apart (Kass & Raftery 1995: strong evidence begins there)


@dataclass(frozen=True)
class Explanation:
    """Effects at their locations, the fit of the model that has them, and its deviance drop from the baseline model; `p` is
    that of the last effect beside the others, corrected for the number of candidates."""

    applied: tuple[Candidate, ...]
    fit: Fit
    deviance_drop: float
    n_unknown: int  # of the effects
    p: float

    @classmethod
    def of(cls, trial: Trial) -> Explanation:
        return cls((trial.candidate,), trial.fit, trial.deviance_drop, trial.n_unknown, trial.p)

    @classmethod
    def of_pair(cls, first: Trial, second: Trial) -> Explanation:
        """A trial of a second effect beside that of a first one."""
        return cls(
            (first.candidate, second.candidate),
            second.fit,
            first.deviance_drop + second.deviance_drop,
            first.n_unknown + second.n_unknown,
            second.p,
        )

    @property
    def delta_bic(self) -> float:
        return float(self.deviance_drop - self.n_unknown * np.log(self.fit.likelihood.n_residual))

    @property
    def names(self) -> tuple[str, ...]:
        """Of its effects, in alphabetical order."""
        return tuple(sorted(candidate.name for candidate in self.applied))

    @property
    def location(self) -> str:
        """Of its effects, in the order of their names."""
        return " and ".join(
            str(each.effect) for each in sorted(self.applied, key=lambda each: (each.name, str(each.effect)))
        )

    @property
    def label(self) -> str:
        """Its effects for people; where they have one name, with their locations."""
        if len(set(self.names)) < len(self.names):
            return " and ".join(f"{each.name} {each.effect}" for each in self.applied)
        return " and ".join(each.name for each in self.applied)

    def is_same(self, other: Explanation) -> bool:
        """Whether it has the same effects at the same locations, in whatever order."""
        return len(self.applied) == len(other.applied) and all(each in other.applied for each in self.applied)

    def is_near(self, other: Explanation) -> bool:
        """Whether it explains the data about as well as another one, or better."""
        return max(self.delta_bic - other.delta_bic, self.deviance_drop - other.deviance_drop) > -NEAR


def ranked_explanations(found: Iterable[Explanation]) -> list[Explanation]:
    """Different ones, highest ΔBIC first; of the same effects the best fit."""
    different: list[Explanation] = []
    for each in sorted(found, key=lambda each: -each.delta_bic):
        if not any(each.is_same(other) for other in different):
            different.append(each)
    return different


def best_of_names(found: Sequence[Explanation]) -> list[Explanation]:
    """The first location of each set of effects."""
    first: dict[tuple[str, ...], Explanation] = {}
    for each in found:
        first.setdefault(each.names, each)
    return list(first.values())
