"""What the columns of waveforms may hold, by their headings: a proposal to be checked, never read by itself."""

from __future__ import annotations

import re
from collections.abc import Sequence

from measurements.formats.column_guess import PHASE, SPEED

KEYPHASOR = re.compile(r"key.?phas|\bkph|\bkp\b|tach|trigger|\bpulse|1/rev|once.per", re.IGNORECASE)
TIME = re.compile(r"^t\b|\btime\b|\bzeit\b", re.IGNORECASE)
UNIT = re.compile(r"\s*[(\[][^)\]]*[)\]]\s*$")
NAMES = re.compile(r"[^\s=@][^=@]*")  # of a probe, in `columns` and `probes`
MOST_SIGNALS = 64  # more columns than this are named by hand


def guessed_waveforms(headings: Sequence[str]) -> tuple[str, ...]:
    """`columns` of format=waveform as the headings suggest them; empty where not just one of them speaks of a keyphasor, or others of
    speeds or phases, which a table of vectors has.

    >>> guessed_waveforms(["t (s)", "KPH", "probe A (um)", "probe B (um)"])
    ('time=t (s)', 'keyphasor=KPH', 'signal.probe A=probe A (um)', 'signal.probe B=probe B (um)')
    >>> guessed_waveforms(["rpm", "amp", "phase"])
    ()
    """
    filled = [each for each in headings if each.strip()]
    pulses = [each for each in filled if KEYPHASOR.search(each)]
    times = [each for each in filled if TIME.search(each) and each not in pulses]
    signals = [each for each in filled if each not in (*pulses, *times)]
    names = [UNIT.sub("", each).strip() for each in signals]
    if any(SPEED.search(each) for each in filled) or any(PHASE.search(each) for each in signals):
        return ()
    if len(pulses) != 1 or len(times) > 1 or not 0 < len(signals) <= MOST_SIGNALS:
        return ()
    if len(set(names)) < len(names) or not all(map(NAMES.fullmatch, names)):
        return ()
    return (
        *(f"time={each}" for each in times),
        f"keyphasor={pulses[0]}",
        *(f"signal.{name}={heading}" for name, heading in zip(names, signals)),
    )
