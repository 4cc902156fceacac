"""Finding of an identification in a line: how well the unknowns are known."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np

from ksmea.records.estimate import Shown
from ksmea.records.identification import IdentificationRecord
from ksmea.show.statements import ANGLE, half_width, with_unit
from ksmea.show.text import capital, fit_verdict, number

MOST_NAMES = 3  # of one unit that are written out


def finding(record: IdentificationRecord) -> str:
    """How well the unknowns are known, or that the model does not explain the data."""
    test = record.lack_of_fit
    if test is not None and test.rejected:
        return capital(fit_verdict(test))
    return known_to({part.name: part.shown for part in record.parameters})


def known_to(unknowns: Mapping[str, Shown]) -> str:
    """Half-widths of the intervals, the widest of each unit, and the unknowns that have none.

    >>> known_to({"kxx": Shown(50.0, 49.9, 50.1, "MN/m"), "phase": Shown(40.0, 39.6, 40.4, "deg")})
    'All 2 unknowns are known: kxx to 0.2 %, phase to 0.4°'
    >>> known_to({"kxx": Shown(50.0, 49.9, 50.1, "MN/m"), "cxx": Shown(1.0, 0.5, float("nan"), "kN s/m")})
    'Known: kxx to 0.2 %; not known from both sides: cxx'
    """
    by_unit: dict[str, list[str]] = defaultdict(list)
    for name, of in unknowns.items():
        if np.isfinite([of.low, of.high]).all():
            by_unit[of.unit].append(name)
    known = ", ".join(_widest(names, unknowns) for names in by_unit.values())
    others = [name for name, of in unknowns.items() if name not in by_unit[of.unit]]
    if not known:
        return f"None of {len(unknowns)} unknowns is known from both sides"
    if not others:
        return f"All {len(unknowns)} unknowns are known: {known}"
    return f"Known: {known}; not known from both sides: {_listed(others)}"


def _widest(names: Sequence[str], unknowns: Mapping[str, Shown]) -> str:
    shown = [unknowns[name] for name in names]
    halves = [half_width(of) or 0.0 for of in shown]
    if shown[0].unit == ANGLE or not all(of.value for of in shown):
        half = float(f"{max(halves):.1g}")
        return f"{_listed(names)} to {with_unit(half, shown[0].unit, half)}"
    share = max(100 * half / abs(of.value) for half, of in zip(halves, shown, strict=True))
    return f"{_listed(names)} to {number(share, 2)} %"


def _listed(names: Sequence[str]) -> str:
    """The names, or the first of many and how many more there are."""
    if len(names) <= MOST_NAMES:
        return ", ".join(names)
    return f"{', '.join(names[: MOST_NAMES - 1])} and {len(names) - MOST_NAMES + 1} more"
