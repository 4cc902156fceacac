"""Assumed true values for studies that need some only to linearise at.

They are the midpoints of the limits, and marked as such.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from bench.command_line.overrides import override
from bench.plan.plan import Cell
from bench.plan.study import Study
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.problem.parameters import middles

ASSUMED = "assumed"  # where settings keep the names of unknowns whose true values are such
SYNTHETIC, TRUTH = "synthetic", "truth"


def with_assumed_values(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings of a run, with a true value for each unknown of its problem.

    Unknowns without a value in the problem or measurement.truth take the midpoint of their limits, if the study allows
    that (`takes_middles`).
    """
    source, chosen = settings["measurement"], settings["problem"]
    study: type[Study] = registry.plugin_class("study", settings["study"]["name"])
    if not study.takes_middles or source["name"] != SYNTHETIC:
        return dict(settings)
    problem = registry.create("problem", chosen["name"], {name: chosen[name] for name in chosen if name != "name"})
    parameters, given = problem.build().parameters, source.get(TRUTH) or {}
    missing = [name for name in parameters.names if name not in {**problem.reference(), **given}]
    if not missing:
        return dict(settings)
    truth = {**given, **middles(parameters, missing)}
    return {**settings, "measurement": {**source, TRUTH: truth}, ASSUMED: missing}


def assumed_note(cell: Cell) -> str:
    """Which values were assumed, as the word that gives others; '' where none were."""
    said = _said(cell.settings)
    return f"note: {said}" if said else ""


@contextmanager
def assumed_values_in_errors(settings: Mapping[str, Any]) -> Iterator[None]:
    """An error of true values says which of them were assumed: nobody gave those."""
    try:
        yield
    except SettingError as error:
        said = _said(settings)
        if not said or error.setting != f"measurement.{TRUTH}":
            raise
        raise SettingError(f"{error}; {said}") from error


def _said(settings: Mapping[str, Any]) -> str:
    names = settings.get(ASSUMED)
    if not names:
        return ""
    truth = {name: float(f"{value:.4g}") for name, value in settings["measurement"][TRUTH].items()}
    return (
        f"no value is known of {', '.join(names)}: the middles of the limits are taken, the geometric ones where these lie a"
        f" decade or more apart; give yours in place of them: '{override(f'measurement.{TRUTH}', truth)}'"
    )
