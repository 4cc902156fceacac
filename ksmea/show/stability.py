"""The stability of a rotor in a sentence."""

from __future__ import annotations

from collections.abc import Iterator

from ksmea.records.stability import StabilityRecord
from ksmea.units import RPM


def stability_text(record: StabilityRecord | None) -> Iterator[str]:
    """From which speed on free motions grow, with its interval; nothing where the problem cannot tell."""
    if record is None:
        return
    level, above = f"{100 * record.level:g} %", f"{record.searched / RPM:.0f} rpm, the highest searched"
    if record.threshold is None:
        perhaps = "" if record.low is None else f", but perhaps not from {_speed(record.low)} on ({level})"
        yield f"stable up to {above}{perhaps}"
        return
    ends = f"{_speed(record.low)} to {'above ' + above if record.high is None else _speed(record.high)}"
    yield f"unstable from {_speed(record.threshold)} on, {level} interval {ends}"
    if record.is_violated:
        yield "warning: no steady response exists above that speed, so that a machine that runs there is another one"


def _speed(speed: float | None) -> str:
    return f"{speed / RPM:.0f} rpm" if speed else "rest"
