"""Bearing tables as texts without headings.

ANSYS COMBI214, in fixed columns, and DyRoBeS, which is recognised and refused.

ANSYS: three titles; three integers of ten columns (number of speeds, 1 for lbf/in, 1 for rpm); then for each speed its number and the speed
(I10, F10.2), K11 K12 K21 K22 and C11 C12 C21 C22 (4E15.7 each). The layout is from its manual. DyRoBeS has a number for the units, whose meaning
no public description gives.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

from ksmea.errors import SettingError, described
from ksmea.units import POUND_FORCE_PER_INCH, RPM
from problems.rotor.finite_elements.bearing import DAMPINGS, STIFFNESSES

TITLES, WIDTHS, WIDTH = 3, (10, 20), 15  # ends of the columns of a speed; the width of a coefficient
HEAD_OF_ANSYS = re.compile(r"(?=.{21,30}$) *\d+ +[01] +[01]")
HEAD_OF_DYROBES = re.compile(r"\s*\d+\s*,\s*(\d+)\s*,\s*(?:8|12|24)\s*,\s*[01]\s*,")
MOST_SPEEDS = 10_000


def is_ansys(text: str) -> bool:
    """Whether the fourth line is the head of such a table."""
    lines = text.splitlines()[: TITLES + 1]
    return len(lines) > TITLES and HEAD_OF_ANSYS.fullmatch(lines[TITLES].rstrip()) is not None


def require_no_dyrobes(text: str, path: str) -> None:
    """Raise `SettingError` for a table of DyRoBeS."""
    if found := HEAD_OF_DYROBES.match(text.partition("\n")[0]):
        raise SettingError(
            f"{path}: expected a table whose units are said, got one of DyRoBeS with the number {found[1]} for them; make a CSV of"
            " it with headings such as kxx [N/m]"
        )


def ansys_columns(text: str, path: str) -> dict[str, list[float]]:
    """Columns in SI by name."""
    lines = text.splitlines()[TITLES:]
    n_speed, in_pounds, in_rpm = (int(each) for each in lines[0].split())
    if not 1 <= n_speed <= MOST_SPEEDS or len(lines) < 1 + 3 * n_speed:
        raise SettingError(f"{path}: expected three lines for each of {n_speed} speeds, got {len(lines) - 1} lines")
    force, speed = POUND_FORCE_PER_INCH if in_pounds else 1.0, RPM if in_rpm else 1.0
    found: dict[str, list[float]] = {name: [] for name in ("speed", *STIFFNESSES, *DAMPINGS)}
    for start in range(1, 1 + 3 * n_speed, 3):
        found["speed"].append(speed * _number(lines[start][slice(*WIDTHS)], TITLES + start, path))
        for step, names in ((1, STIFFNESSES), (2, DAMPINGS)):
            for name, cell in zip(names, _cells(lines[start + step]), strict=True):
                found[name].append(force * _number(cell, TITLES + start + step, path))
    return found


def _cells(line: str) -> Sequence[str]:
    """Four coefficients in columns of 15."""
    return [line[left:right] for left, right in pairwise(range(0, 5 * WIDTH, WIDTH))]


def _number(cell: str, line: int, path: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = float("nan")
    if not abs(value) < float("inf"):
        raise SettingError(f"{path}: line {line + 1}: expected a number, got {described(cell.strip() or None)}")
    return value
