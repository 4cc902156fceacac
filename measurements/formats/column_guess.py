"""Likely meaning of a table's or waveform's columns, by their headings: a proposal to be checked."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

from measurements.formats.questions import OpenQuestion

SPEED = re.compile(r"speed|rpm|1/min|omega|drehzahl|^n\b", re.IGNORECASE)
PHASE = re.compile(r"phase|phas\b|(?<!probe )\b(?:angle|winkel)\b|\bph\b|\bdeg|°", re.IGNORECASE)
AMPLITUDE = re.compile(r"ampl|amp\b|\bmag|displ|\b(um|mil)\b|µm", re.IGNORECASE)
Guess = Callable[[Sequence[str]], tuple[str, ...]]  # `columns` of headings, empty where these do not tell

PLACEHOLDERS = ("speed=HEADING", "amplitude.NAME=HEADING", "phase.NAME=HEADING")
WORD = re.compile(r"[^\W_]+")
HARMONIC = re.compile(r"[0-9]*[0-9½]x", re.IGNORECASE)


def guessed_columns(headings: Sequence[str]) -> tuple[str, ...]:
    """`columns` as the headings suggest them; empty where they do not tell the speed from the amplitudes.

    >>> guessed_columns(["RPM", "Amp (mil pp)", "Phase (deg)"])
    ('speed=RPM', 'amplitude=Amp (mil pp)', 'phase=Phase (deg)')
    >>> guessed_columns(["a", "b"])
    ()
    >>> guessed_columns(["rpm", "DE amp", "NDE amp", "DE phase", "NDE phase"])[1:3]
    ('amplitude.DE=DE amp', 'phase.DE=DE phase')
    """
    phases = [each for each in headings if PHASE.search(each)]
    speeds = [each for each in headings if SPEED.search(each) and each not in phases]
    amplitudes = [each for each in headings if AMPLITUDE.search(each) and each not in (*phases, *speeds)]
    if len(speeds) != 1 or not amplitudes or len(phases) not in (0, len(amplitudes)):
        return ()
    columns = [f"speed={speeds[0]}"]
    if len(amplitudes) == 1:
        return (*columns, f"amplitude={amplitudes[0]}", *(f"phase={each}" for each in phases))
    of_amplitudes, of_phases = _by_probe(amplitudes), _by_probe(phases)
    if not of_amplitudes or (phases and of_phases.keys() != of_amplitudes.keys()):
        return ()
    for name, heading in of_amplitudes.items():
        columns.append(f"amplitude.{name}={heading}")
        columns += [f"phase.{name}={of_phases[name]}"] if phases else []
    return tuple(columns)


def _by_probe(headings: Sequence[str]) -> dict[str, str]:
    """Headings of one kind by the words that only some of them have; empty where these are no names of probes, or stand twice."""
    words = [WORD.findall(heading) for heading in headings]
    count = Counter(word for each in words for word in set(each))
    names = [
        " ".join(word for word in each if count[word] < len(headings) and not _tells_content(word)) for each in words
    ]
    if len(set(names)) < len(names) or not all(names) or all(map(HARMONIC.fullmatch, names)):
        return {}
    return dict(zip(names, headings))


def _tells_content(word: str) -> bool:
    """Whether a word says what a column holds, not which probe it is of."""
    return bool(AMPLITUDE.search(word) or PHASE.search(word))


def columns_question(
    said: str,
    lines: Iterable[Sequence[str]],
    guess: Guess = guessed_columns,
    placeholders: tuple[str, ...] = PLACEHOLDERS,
) -> OpenQuestion:
    """The question what columns hold, with what the headings suggest: those of the first of some lines that suggest anything, or
    else the `placeholders`."""
    guessed = next(filter(None, map(guess, lines)), ())
    suggested = (
        "; the headings suggest those below, check them"
        if guessed
        else "; what else is open is seen once they are known"
    )
    return OpenQuestion(f"{said}{suggested}", "columns", guessed or placeholders, list(guessed) or None)


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
