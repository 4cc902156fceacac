"""Parts of a polar plot: rings at round amplitudes, angles, and speeds at points that lie apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

from ksmea.arrays import Array, ComplexArray, peak_indices
from ksmea.measurement.notation import LAG, Notation
from ksmea.show.charts.chart import Element, Level, Line, Words
from ksmea.show.charts.colours import CONTEXT
from ksmea.show.readings import speed_digits

N_RING, LEAST_STEP = 3, 0.6  # circles, and the least distance of theirs, of an equal one
LABELLED = 6  # speeds with a number
LEAST_APART = 0.25  # of the largest amplitude: points that are nearer need no further number
WIDTH, HEIGHT, AWAY = 0.42, 0.18, 0.15  # of the largest amplitude: a number, and its distance, in a panel 2 inches wide
DIAGONALS = np.exp(0.25j * np.pi * np.array([-1, -3, 3, 1]))
BEYOND = 1.2  # times the largest measured amplitude: where curves end
REACH = 1.35  # times the largest measured amplitude: where axes end
FULL_TURN = np.linspace(0, 2 * np.pi, 121)


def phase_in_words(notation: Notation) -> str:
    """How a polar plot shows phases: '0° of phase to the right, lead anticlockwise'."""
    turning = "clockwise" if notation.phase == LAG else "anticlockwise"
    return f"0° of phase to the right, {notation.phase} {turning}"


def rings(reach: float, notation: Notation, speeds: Sequence[Words] = ()) -> Iterator[Element]:
    """Circles at round radii, the outer one with its value, and axes.

    Axes have the phase of a notation at their ends. The value stands on a diagonal on which no name of `speeds` hides it.
    """
    raw = reach / N_RING
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * next(each for each in (1, 2, 5, 10) if each * power >= LEAST_STEP * raw)
    radii = np.arange(1, np.floor(reach / step) + 1) * step
    taken = _moved(np.array([complex(each.x, each.y) for each in speeds]), reach)
    for radius in radii:
        yield Line(radius * np.cos(FULL_TURN), radius * np.sin(FULL_TURN), width=0.5, colour=CONTEXT, opacity=0.6)
    if len(radii):
        free = [each for each in radii[-1] * DIAGONALS if not _is_near(each, taken, reach)]
        at = free[0] if free else radii[-1] * DIAGONALS[0]
        side: Literal["left", "right"] = "left" if at.real > 0 else "right"
        yield Words(x=float(at.real), y=float(at.imag), text=f"{radii[-1]:g} {notation.unit}", side=side)
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
    """Points whose numbers do not hide each other.

    The largest amplitude, the first and the last speed and the other resonances come first, then each the one farthest
    from those before.
    """
    size = np.abs(measured)
    largest = float(np.max(size))
    places = _moved(measured, largest)
    peaks = peak_indices(size)
    chosen: list[int] = []

    def free(candidates: Sequence[int]) -> list[int]:
        return [at for at in candidates if not _is_near(places[at], places[chosen], largest)]

    for at in (int(np.argmax(size)), 0, len(measured) - 1, *peaks[np.argsort(-size[peaks])].tolist()):
        chosen += free([at]) if len(chosen) < LABELLED else []
    while len(chosen) < LABELLED and (candidates := free(range(len(measured)))):
        apart = np.min(np.abs(measured[candidates][:, None] - measured[None, chosen]), axis=1)
        if apart.max() < LEAST_APART * largest:
            break
        chosen.append(candidates[int(np.argmax(apart))])
    return sorted(chosen)


def _moved(points: ComplexArray, reach: float) -> ComplexArray:
    """Places of the numbers of points."""
    return np.asarray(points + AWAY * reach * np.exp(1j * np.angle(points)))


def _is_near(place: complex, taken: ComplexArray, reach: float) -> bool:
    """Whether a number hides one of others."""
    apart = (place - taken) / reach
    return bool(np.any((np.abs(apart.real) < WIDTH) & (np.abs(apart.imag) < HEIGHT)))
