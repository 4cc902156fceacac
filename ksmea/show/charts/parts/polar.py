"""Parts of a polar plot: rings at round amplitudes, angles, and speeds at points that lie apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.notation import LAG, Notation
from ksmea.show.charts.chart import Element, Level, Line, Words
from ksmea.show.charts.colours import CONTEXT
from ksmea.show.readings import speed_digits

N_RING, LEAST_STEP = 3, 0.6  # circles, and the least distance of theirs, of an equal one
LABELLED = 6  # speeds with a number
LEAST_APART = 0.25  # of the largest amplitude: numbers that are nearer hide each other
BEYOND = 1.2  # times the largest measured amplitude: where curves end
REACH = 1.35  # times the largest measured amplitude: where axes end
FULL_TURN = np.linspace(0, 2 * np.pi, 121)


def phase_in_words(notation: Notation) -> str:
    """How a polar plot shows phases: '0° of phase to the right, lead anticlockwise'."""
    turning = "clockwise" if notation.phase == LAG else "anticlockwise"
    return f"0° of phase to the right, {notation.phase} {turning}"


def rings(reach: float, notation: Notation) -> Iterator[Element]:
    """Circles at round radii with their values, and axes with the phase at their ends, as a notation counts it."""
    raw = reach / N_RING
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * next(each for each in (1, 2, 5, 10) if each * power >= LEAST_STEP * raw)
    for radius in np.arange(1, np.floor(reach / step) + 1) * step:
        yield Line(radius * np.cos(FULL_TURN), radius * np.sin(FULL_TURN), width=0.5, colour=CONTEXT, opacity=0.6)
        yield Words(x=0.0, y=-float(radius), text=f"{radius:g}", edge="top", offset=(0.0, -1.0))
    yield Level(at=0.0, dash="solid", width=0.4, colour=CONTEXT)
    yield Level(at=0.0, along="x", dash="solid", width=0.4, colour=CONTEXT)
    end = REACH * reach
    ends = {0: (end, 0.0), 90: (0.0, end), 180: (-end, 0.0), 270: (0.0, -end)}
    for lead, (x, y) in ends.items():
        shown = f" {notation.angle(lead):.0f}°"
        yield Words(x=x, y=y, text=shown, side="left" if lead else "right", edge="top" if lead == 90 else "bottom")


def within(values: ComplexArray, reach: float) -> ComplexArray:
    """A curve as it is drawn: without what lies far beyond what was measured."""
    return np.where(np.abs(values) <= BEYOND * reach, values, np.nan)


def speeds_said(speed: Array, notation: Notation) -> list[str]:
    """Speeds as they are shown at the pointer, '3820 rpm'; '' of a gap."""
    return [f"{speed_digits(each, notation)} {notation.speed}" if np.isfinite(each) else "" for each in speed]


def speeds_at(measured: ComplexArray, said: Sequence[str]) -> Iterator[Words]:
    """The speed at points that lie apart, away from the origin."""
    for at in labelled(measured):
        away = measured[at] / max(abs(measured[at]), 1e-12)
        offset = (9.0 * away.real, 9.0 * away.imag)
        place = float(measured[at].real), float(measured[at].imag)
        yield Words(x=place[0], y=place[1], text=said[at].partition(" ")[0], offset=offset, has_ground=True)


def labelled(measured: ComplexArray) -> list[int]:
    """Points that lie apart: each the one farthest from those before.

    The first speed and the largest amplitude are first.
    """
    chosen = [0, int(np.argmax(np.abs(measured)))]
    least = LEAST_APART * float(np.max(np.abs(measured)))
    while len(chosen) < min(LABELLED, len(measured)):
        apart = np.min(np.abs(measured[:, None] - measured[None, chosen]), axis=1)
        if apart.max() < least:
            break
        chosen.append(int(np.argmax(apart)))
    return sorted(set(chosen))
