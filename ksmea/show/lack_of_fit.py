"""What the lack-of-fit test of a fit says, and what that means for what is made of the fit."""

from __future__ import annotations

from collections.abc import Iterator

from ksmea.records.identification import LackOfFit


def fit_verdict(test: LackOfFit) -> str:
    """Whether the model explains the data within their noise."""
    if test.rejected:
        return f"{fit_rejection(test)}; +experiment=diagnose looks for the cause"
    return f"the model explains the data within their noise {_fit_evidence(test)}"


def fit_rejection(test: LackOfFit) -> str:
    """That it does not, with the evidence."""
    return f"the model does not explain the data within their noise {_fit_evidence(test)}"


def fit_warning(test: LackOfFit | None, made_of_it: str) -> Iterator[str]:
    """What a rejected fit means for `made_of_it`; nothing where the fit is good or was not tested."""
    if test is not None and test.rejected:
        yield (
            f"warning: {fit_rejection(test)}, so that {made_of_it} below hold for a wrong model at wrong values and may"
            " mislead; run +experiment=diagnose first"
        )


def _fit_evidence(test: LackOfFit) -> str:
    return f"({test.statistic}, p = {test.p:.2g})"
