"""What the columns of a table may hold, by their headings: a proposal to be checked, never read by itself."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from string import ascii_uppercase

from measurements.formats.questions import OpenQuestion

SPEED = re.compile(r"speed|rpm|1/min|omega|drehzahl|^n\b", re.IGNORECASE)
PHASE = re.compile(r"phase|phas\b|\bph\b|\bdeg|°", re.IGNORECASE)
AMPLITUDE = re.compile(r"ampl|amp\b|\bmag|displ|\b(um|mil)\b|µm", re.IGNORECASE)
UNTOLD = ("speed=HEADING", "amplitude.NAME=HEADING", "phase.NAME=HEADING")
MOST_PROBES = len(ascii_uppercase)


def guessed_columns(headings: Sequence[str]) -> tuple[str, ...]:
    """`columns` as the headings suggest them; empty where they do not tell the speed from the amplitudes.

    >>> guessed_columns(["RPM", "Amp (mil pp)", "Phase (deg)"])
    ('speed=RPM', 'amplitude=Amp (mil pp)', 'phase=Phase (deg)')
    >>> guessed_columns(["a", "b"])
    ()
    """
    phases = [each for each in headings if PHASE.search(each)]
    speeds = [each for each in headings if SPEED.search(each) and each not in phases]
    amplitudes = [each for each in headings if AMPLITUDE.search(each) and each not in (*phases, *speeds)]
    if len(speeds) != 1 or not 1 <= len(amplitudes) <= MOST_PROBES or len(phases) not in (0, len(amplitudes)):
        return ()
    names = [""] if len(amplitudes) == 1 else [f".{letter}" for letter in ascii_uppercase]
    columns = [f"speed={speeds[0]}"]
    for number, (name, heading) in enumerate(zip(names, amplitudes)):
        columns.append(f"amplitude{name}={heading}")
        columns += [f"phase{name}={heading}" for heading in phases[number : number + 1]]
    return tuple(columns)


def columns_question(said: str, lines: Iterable[Sequence[str]]) -> OpenQuestion:
    """The question what columns hold, with what the headings suggest: those of the first of some lines that suggest anything."""
    guess = next(filter(None, map(guessed_columns, lines)), ())
    suggested = (
        "; the headings suggest those below, check them" if guess else "; what else is open is seen once they are known"
    )
    return OpenQuestion(f"{said}{suggested}", "columns", guess or UNTOLD, list(guess) or None)
