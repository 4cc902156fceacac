"""Remarks where a problem and a measurement look like a slip: nothing is refused, as odd machines exist."""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array
from ksmea.contracts import Problem
from ksmea.errors import SettingError
from ksmea.measurement import Measurement
from ksmea.units import HERTZ, RPM

NEAR_BAND = 0.3  # part of a band's ends within which a critical speed still shapes its response
FAR = 8.0  # measured speeds that many times below the first critical are hardly those of a run-up
MAX_SITES = 60  # larger rotors take longer than a second
REACHES = (
    1 + NEAR_BAND,
    4.0,
    12.0,
    30.0,
    61.0,
)  # times the highest speed, one after the other until a critical is found
MISREAD = {"Hz": HERTZ / RPM, "rad/s": 1 / RPM}  # what a number of this unit is multiplied by to be one in rpm


def slips(problem: Problem, x: Array, measurement: Measurement) -> tuple[str, ...]:
    """Remarks on the measured band beside the critical speeds at values x (d,) SI. Of a problem that does not know its
    modes, or is too large to ask for them in passing, nothing is said."""
    lowest, highest = float(np.min(measurement.speed)), float(np.max(measurement.speed))
    criticals = _first_criticals(problem, x, highest)
    if criticals is None or np.any((criticals >= (1 - NEAR_BAND) * lowest) & (criticals <= (1 + NEAR_BAND) * highest)):
        return ()
    return (_no_critical_text(criticals, lowest, highest), *_unit_texts(criticals, lowest, highest))


def _first_criticals(problem: Problem, x: Array, highest: float) -> Array | None:
    """Critical speeds up to the first reach that has one, rad/s; None where the problem cannot tell."""
    if not 0 < len(problem.sites) <= MAX_SITES:
        return None
    found = np.empty(0)
    try:
        for reach in REACHES:
            found = problem.critical_speeds(x, reach * highest)
            if len(found):
                break
    except (SettingError, ArithmeticError, ValueError, np.linalg.LinAlgError):
        return None
    return found


def _no_critical_text(criticals: Array, lowest: float, highest: float) -> str:
    band = f"{lowest / RPM:.0f} to {highest / RPM:.0f} rpm"
    said = (
        f"no critical speed of the model lies inside the measured band or within {100 * NEAR_BAND:.0f} % of it ({band})"
    )
    if not len(criticals):
        return said
    nearest = criticals[np.argmin(np.abs(np.log(criticals / highest)))]
    return f"{said}; the nearest one is at {nearest / RPM:.0f} rpm"


def _unit_texts(criticals: Array, lowest: float, highest: float) -> tuple[str, ...]:
    """A unit that the speeds may have been in, where they lie far below the first critical."""
    if not len(criticals) or highest >= criticals[0] / FAR:
        return ()
    fitting = [
        (unit, factor)
        for unit, factor in MISREAD.items()
        if np.any((criticals >= factor * lowest) & (criticals <= factor * highest))
    ]
    if not fitting:
        return ()
    units = " / ".join(unit for unit, _ in fitting)
    factors = " or ".join(f"{factor:.3g}" for _, factor in fitting)
    return (f"speeds look like {units}: {factors} times as high they enclose a critical speed; give them in rpm",)
