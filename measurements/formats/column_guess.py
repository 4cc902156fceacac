"""Likely meaning of a table's or waveform's columns, by their headings: a proposal to be checked."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

from measurements.formats.questions import OpenQuestion
from measurements.formats.unit_texts import amplitude_unit, is_voltage, unit_in_heading

# English, German, French, Spanish, Portuguese, Italian, Dutch, Polish, Russian, Chinese, Japanese; underscores are blanks
SPEED = re.compile(
    r"speed|\bspd\b|rpm|1/min|omega|drehzahl|u/min|^n\b|vitesse|tr/min|velocidad|rotação|velocità|\bgiri\b|toerental|prędkość|obroty"
    r"|скорость|частота вращения|об/мин|转速|轉速|回転",
    re.IGNORECASE,
)
PHASE = re.compile(
    r"phase|phas\b|(?<!probe )\b(?:angle|winkel|ángulo|angolo|ângulo|hoek|kąt)\b|\bph[0-9]?\b|\bdeg|°|\bfase\b|\bfaza\b|фаза|угол|相位|相角|位相",
    re.IGNORECASE,
)
AMPLITUDE = re.compile(
    r"ampl|amp[0-9]?\b|\bmag|displ|\bdisp?\b|\bvib|\b(um|mils?)\b|µm|schwingweg|ausschlag|deplac|déplac|desplaz|desloc|ampiezza|spostamento"
    r"|verplaatsing|przemieszczenie|амплитуда|перемещение|幅值|振幅|幅度|変位",
    re.IGNORECASE,
)
Guess = Callable[[Sequence[str]], tuple[str, ...]]  # `columns` of headings, empty where these do not tell

PLACEHOLDERS = ("speed=HEADING", "amplitude.NAME=HEADING", "phase.NAME=HEADING")
WORD = re.compile(r"[^\W_]+")
KIND_BEFORE_NUMBER = re.compile(r"^(?:ampl?|mag|disp|vib|a|phase?|phas|ph|p|lag|lead)(?=[0-9])", re.IGNORECASE)
HARMONIC = re.compile(r"[0-9]*[0-9½]x", re.IGNORECASE)


def guessed_columns(headings: Sequence[str]) -> tuple[str, ...]:
    """`columns` as the headings suggest them; empty if they do not tell the speed from the amplitudes.

    >>> guessed_columns(["RPM", "Amp (mil pp)", "Phase (deg)"])
    ('speed=RPM', 'amplitude=Amp (mil pp)', 'phase=Phase (deg)')
    >>> guessed_columns(["a", "b"])
    ()
    >>> guessed_columns(["rpm", "DE amp", "NDE amp", "DE phase", "NDE phase"])[1:3]
    ('amplitude.DE=DE amp', 'phase.DE=DE phase')
    >>> guessed_columns(["speed_rpm", "X_um_pp", "X_deg", "Y_um_pp", "Y_deg"])[1:3]
    ('amplitude.X=X_um_pp', 'phase.X=X_deg')
    >>> guessed_columns(["Drehzahl [1/min]", "Schwingweg", "Phasenwinkel"])
    ('speed=Drehzahl [1/min]', 'amplitude=Schwingweg', 'phase=Phasenwinkel')
    """
    phases = [each for each in headings if _means(PHASE, each)]
    speeds = [each for each in headings if _means(SPEED, each) and each not in phases]
    amplitudes = [each for each in headings if _is_amplitude(each) and each not in (*phases, *speeds)]
    if len(speeds) != 1 or not amplitudes or len(phases) not in (0, len(amplitudes)):
        return ()
    columns = [f"speed={speeds[0]}"]
    if len(amplitudes) == 1:
        return (*columns, f"amplitude={amplitudes[0]}", *(f"phase={each}" for each in phases))
    of_amplitudes, of_phases = _by_probe(amplitudes), _by_probe(phases)
    if not of_amplitudes or (phases and of_phases.keys() != of_amplitudes.keys()):  # A1 and ph1 are of the probe 1
        of_amplitudes, of_phases = (_by_probe(each, KIND_BEFORE_NUMBER) for each in (amplitudes, phases))
    if not of_amplitudes or (phases and of_phases.keys() != of_amplitudes.keys()):
        return ()
    for name, heading in of_amplitudes.items():
        columns.append(f"amplitude.{name}={heading}")
        columns += [f"phase.{name}={of_phases[name]}"] if phases else []
    return tuple(columns)


def _means(what: re.Pattern[str], heading: str) -> bool:
    return what.search(heading.replace("_", " ")) is not None


def _is_amplitude(heading: str) -> bool:
    """Whether a heading speaks of a vibration, or has the unit of one."""
    unit = unit_in_heading(heading)
    return _means(AMPLITUDE, heading) or bool(unit and (amplitude_unit(unit) or is_voltage(unit)))


def _by_probe(headings: Sequence[str], left_out: re.Pattern[str] | None = None) -> dict[str, str]:
    """Headings of one kind by the words that only some of them have.

    Matches of `left_out` are removed from words first. Empty if the remaining words are not names of probes, or stand
    twice.
    """
    words = [WORD.findall(heading) for heading in headings]
    if left_out is not None:
        words = [[left_out.sub("", word) for word in each] for each in words]
    count = Counter(word for each in words for word in set(each))
    names = [
        " ".join(word for word in each if count[word] < len(headings) and not _tells_content(word)) for each in words
    ]
    if len(set(names)) < len(names) or not all(names) or all(map(HARMONIC.fullmatch, names)):
        return {}
    return dict(zip(names, headings))


def _tells_content(word: str) -> bool:
    """Whether a word says what a column holds, not which probe it is of."""
    return bool(AMPLITUDE.search(word) or PHASE.search(word) or amplitude_unit(word))


def columns_question(
    said: str,
    lines: Iterable[Sequence[str]],
    guess: Guess = guessed_columns,
    placeholders: tuple[str, ...] = PLACEHOLDERS,
    *,
    is_plain: bool = False,
) -> OpenQuestion:
    """The question what columns hold, with suggestions by the headings.

    They are from the first of the lines that suggest anything, or else the `placeholders`. With `is_plain` the file has
    no headings, and columns have numbers.
    """
    if is_plain:
        numbered = tuple(each.replace("HEADING", "#NUMBER") for each in placeholders)
        return OpenQuestion(f"{said}; the file has no headings: columns are #1, #2, …", "columns", numbered, None)
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
    """Setting `columns` of format=waveform as the headings suggest it.

    Empty if not just one of them speaks of a keyphasor, or others of speeds or phases, which a table of vectors has.

    >>> guessed_waveforms(["t (s)", "KPH", "probe A (um)", "probe B (um)"])
    ('time=t (s)', 'keyphasor=KPH', 'signal.probe A=probe A (um)', 'signal.probe B=probe B (um)')
    >>> guessed_waveforms(["rpm", "amp", "phase"])
    ()
    """
    pulses = [each for each in headings if _means(KEYPHASOR, each)]
    if len(pulses) != 1 or any(_means(SPEED, each) for each in headings):
        return ()
    return _waveforms(headings, [f"keyphasor={pulses[0]}"], pulses)


def guessed_unmarked(headings: Sequence[str]) -> tuple[str, ...]:
    """Setting `columns` of format=waveform without a keyphasor.

    Empty if no heading is a time, or several are a speed.

    >>> guessed_unmarked(["t_s", "speed_rpm", "A_um"])
    ('time=t_s', 'speed=speed_rpm', 'signal.A=A_um')
    """
    speeds = [each for each in headings if _means(SPEED, each)]
    if (
        len(speeds) > 1
        or not any(_means(TIME, each) for each in headings)
        or any(_means(KEYPHASOR, h) for h in headings)
    ):
        return ()
    return _waveforms(headings, [f"speed={each}" for each in speeds], speeds)


def _without_unit(heading: str) -> str:
    words = unit_in_heading(heading, in_brackets=False).split()
    tail = "".join(rf"[\s_.]+{re.escape(word)}" for word in words)
    return re.sub(rf"{tail}\s*$", "", UNIT.sub("", heading)).strip()


def _waveforms(headings: Sequence[str], others: Sequence[str], used: Sequence[str]) -> tuple[str, ...]:
    """The time, `others`, and a signal of each heading that is neither.

    Empty if one of them is a phase, or names are not distinct.
    """
    filled = [each for each in headings if each.strip()]
    times = [each for each in filled if _means(TIME, each) and each not in used]
    signals = [each for each in filled if each not in (*used, *times)]
    names = [_without_unit(each) for each in signals]
    if any(_means(PHASE, each) for each in signals):
        return ()
    if len(times) > 1 or not 0 < len(signals) <= MOST_SIGNALS:
        return ()
    if len(set(names)) < len(names) or not all(map(NAMES.fullmatch, names)):
        return ()
    return (
        *(f"time={each}" for each in times),
        *others,
        *(f"signal.{name}={heading}" for name, heading in zip(names, signals)),
    )
