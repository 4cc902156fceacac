"""Two responses over speed and their difference in per cent: the paper's Figs. 4–7, 10 and 11.

The response is drawn on the fine speeds of a record, so that peaks are whole; records without them show the measured speeds. Of the
repetitions the one with the least and the one with the largest difference (rms of its logarithm) are shown, on common axes. Speeds,
amplitudes and names of channels are in a notation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from bench.plan.naming import cell_name
from bench.plan.plan import Plan
from bench.reports.identification.course_charts import figure_number
from ksmea.arrays import Array
from ksmea.measurement.notation import Notation
from ksmea.records.curves import FineResponses, ResponseCurves, as_array
from ksmea.records.record import rounded
from ksmea.show.charts.chart import Axis, Chart, Element, Line, Panel, Points, Words, broken
from ksmea.show.charts.colours import CATEGORIES, CONTEXT, MEASURED, MODEL, PAPER
from ksmea.show.readings import (
    PLAIN,
    amplitude_label,
    speed_at_pointer,
    speed_digits,
    speed_label,
    speed_unit,
    vibration_unit,
)
from ksmea.show.text import two_digits

Kind = Literal["identified", "surrogate"]

DIFFERENCE = "difference (%)"
LOW_PART = 5  # per cent of the differences may lie below their axis
ROOM_FOR_WORDS = 0.3  # of the decades from the least difference to the largest, above that
DIGITS = 4  # of values of lines: less than a line's width
LEAST = 1e-2  # per cent: smaller differences are drawn as this
NAMES = {
    "true": "original",
    "measured": "measured",
    "identified": "identified",
    "modelled": "model",
    "predicted": "surrogate",
}


@dataclass(frozen=True)
class Agreement:
    """Amplitudes (n_speed, n_channel) over speed (n_speed,), compared with a reference.

    They are in the units of `notation`, µm 0-peak and rpm by default. `breaks` begin further runs.
    """

    speed: Array
    reference: Array
    other: Array
    breaks: tuple[int, ...]
    names: tuple[str, str]
    curves: ResponseCurves
    notation: Notation = PLAIN

    @property
    def difference(self) -> Array:
        """Per cent of the reference, without sign."""
        return np.abs(self.other / self.reference - 1) * 100

    @property
    def size(self) -> float:
        """Root mean square of the difference's logarithm, over speeds and channels."""
        ratio = np.log(self.other / self.reference)
        return float(np.sqrt(np.mean(ratio[np.isfinite(ratio)] ** 2)))

    def worst(self) -> tuple[float, int, float]:
        """Speed, channel and size (%) of the largest difference."""
        row, column = np.unravel_index(np.nanargmax(self.difference), self.difference.shape)
        return float(self.speed[row]), int(column), float(self.difference[row, column])

    def said(self, speed: float) -> str:
        """A speed with its unit."""
        return f"{speed_digits(speed, self.notation)} {self.notation.speed}"


def agreement(curves: ResponseCurves, kind: Kind, notation: Notation = PLAIN) -> Agreement | None:
    """The comparison of a run in a notation; None if its record lacks a curve.

    `identified` compares the identified response with the original one, or with measured amplitudes if the original is not known;
    `surrogate` compares the surrogate's prediction, which is of measured speeds only, with the model at the same values.
    """
    fine = curves.fine
    if kind == "identified" and fine is not None and fine.true is not None and fine.identified is not None:
        return _between(fine, "true", "identified", curves, notation)
    pairs = (
        (("modelled", "predicted"),) if kind == "surrogate" else (("true", "identified"), ("measured", "identified"))
    )
    for first, second in pairs:
        if getattr(curves, first) is not None and getattr(curves, second) is not None:
            return _between(curves, first, second, curves, notation)
    return None


def _between(
    of: FineResponses | ResponseCurves, first: str, second: str, curves: ResponseCurves, notation: Notation
) -> Agreement | None:
    one, other = (as_array(getattr(of, name)) / vibration_unit(notation) for name in (first, second))
    ratio = other / one
    if not np.any(np.isfinite(ratio)):
        return None
    speed = as_array(of.speed) / speed_unit(notation)
    return Agreement(speed, one, other, of.breaks, (NAMES[first], NAMES[second]), curves, notation)


def agreement_chart(plan: Plan, cell: int, kind: Kind, found: Sequence[Agreement]) -> Chart:
    """The best and the worst repetition of a cell side by side.

    Each channel has both responses, and their difference below.
    """
    ranked = sorted(found, key=lambda each: each.size)
    shown = {"best": ranked[0], "worst": ranked[-1]} if len(ranked) > 1 else {"": ranked[0]}
    y = _difference_axis(list(shown.values()))
    stacks = tuple(tuple(_stack(each, kind, y, _heading(name, each, len(ranked)))) for name, each in shown.items())
    first, second = ranked[0].names
    number = figure_number(plan, kind)
    name = cell_name(plan, plan.cells[cell]) if len(plan.cells) > 1 else ""
    return Chart(
        f"{number}{_finding(shown, ranked)}{f' ({name})' if name else ''}",
        f"Amplitude over speed, {first} and {second}, and the difference in per cent of the {first} response below, on common axes."
        f"{' Best and worst are the repetitions with the least and the largest rms difference.' if len(shown) > 1 else ''}"
        f"{' A surrogate knows only the measured speeds.' if kind == 'surrogate' else ''}",
        stacks, len(stacks), 4.6 * max(len(stacks), 2),
    )  # fmt: skip


def _finding(shown: Mapping[str, Agreement], ranked: Sequence[Agreement]) -> str:
    """Finding of a figure.

    For example 'The best of 20 repetitions is within 5 % of the original response; the worst misses 3618 rpm by 62 %'."""
    first, second = ranked[0].names
    speed, _, missed = ranked[-1].worst()
    if len(shown) == 1:
        return f"The {second} response is within {_per_cent(missed)} of the {first} one; the largest difference is at {ranked[-1].said(speed)}"
    return (
        f"{second.capitalize()}: the best of {len(ranked)} repetitions is within {_per_cent(ranked[0].worst()[2])} of the {first} response;"
        f" the worst misses {ranked[-1].said(speed)} by {_per_cent(missed)}"
    )


def _per_cent(value: float) -> str:
    return f"{LEAST:g} %" if value < LEAST else f"{two_digits(value)} %"


def _heading(name: str, of: Agreement, n: int) -> str:
    channel = of.notation.name(of.curves.channels[0])
    return f"{name} of {n} repetitions, {channel}" if name else channel


def _stack(of: Agreement, kind: Kind, y: Axis, heading: str) -> Iterator[Panel]:
    for column, channel in enumerate(of.curves.channels):
        x = Axis(speed_label(of.notation), group="speed")
        elements = tuple(_responses(of, kind, column))
        title = heading if column == 0 else of.notation.name(channel)
        yield Panel(elements, x, Axis(amplitude_label(of.notation), "log", group="amplitude"), title, 2.1)
        yield Panel(tuple(_differences(of, kind, column)), x, y, height=1.1)


def _difference_axis(every: Sequence[Agreement]) -> Axis:
    """Axis of differences, from below nearly all of them to above the largest, for its words.

    Changes of their sign are cut off.
    """
    found = np.concatenate([each.difference[np.isfinite(each.difference)] for each in every])
    low, high = float(np.percentile(found, LOW_PART)), float(np.max(found))
    low = max(10.0 ** np.floor(np.log10(max(low, LEAST))), LEAST)
    high = max(high, 10 * low)
    return Axis(DIFFERENCE, "log", low, high * (high / low) ** ROOM_FOR_WORDS, group="difference")


def _responses(of: Agreement, kind: Kind, column: int) -> Iterator[Element]:
    first, second = of.names
    in_speed, in_amplitude = speed_unit(of.notation), vibration_unit(of.notation)
    speed, measured = as_array(of.curves.speed) / in_speed, of.curves.measured
    if kind == "surrogate":
        fine = of.curves.fine
        if fine is not None and fine.modelled is not None:
            curve = as_array(fine.speed) / in_speed, _drawn(as_array(fine.modelled)[:, column] / in_amplitude)
            x, y = (broken(part, fine.breaks) for part in curve)
            yield Line(x, y, width=1.4, name=first, colour=MODEL)
        else:
            yield _line(of, of.reference[:, column], first, MODEL, 1.4)
        yield Points(
            speed,
            of.other[:, column],
            size=4.0,
            is_open=True,
            name=f"{second}, at measured speeds",
            colour=CATEGORIES[2],
        )
        return
    if first != NAMES["measured"]:
        yield _line(of, of.reference[:, column], first, CONTEXT, 4.0, 0.4)
    yield _line(of, of.other[:, column], second, MODEL, 1.2)
    if measured is not None:
        yield Points(
            speed, as_array(measured)[:, column] / in_amplitude, size=3.4, name=NAMES["measured"], colour=MEASURED
        )


def _line(of: Agreement, values: Array, name: str, colour: str, width: float, opacity: float = 1.0) -> Line:
    x, y = (broken(part, of.breaks) for part in (of.speed, _drawn(values)))
    return Line(x, y, width=width, name=name, colour=colour, opacity=opacity)


def _drawn(values: Array) -> Array:
    """Values as a line shows them: a page is smaller by what nobody sees."""
    return np.array([rounded(value, DIGITS) if np.isfinite(value) else np.nan for value in values.tolist()])


def _differences(of: Agreement, kind: Kind, column: int) -> Iterator[Element]:
    values = np.maximum(of.difference[:, column], LEAST)
    is_at_points = kind == "surrogate" or of.names[0] == NAMES["measured"]
    said = f"{{y:.2g}} % at {speed_at_pointer(of.notation)}"
    if is_at_points:
        yield Points(of.speed, values, size=2.6, colour=PAPER, said=said)
    else:
        x, y = (broken(part, of.breaks) for part in (of.speed, _drawn(values)))
        yield Line(x, y, width=1.0, colour=PAPER, said=said)
    speed, worst, missed = of.worst()
    if worst == column and missed > LEAST:
        side: Literal["left", "right"] = "right" if speed > np.mean(of.speed[[0, -1]]) else "left"
        offset = (4.0 if side == "right" else -4.0, 3.0)
        yield Words(
            x=speed,
            y=missed,
            text=f"{_per_cent(missed)} at {of.said(speed)}",
            offset=offset,
            side=side,
            edge="bottom",
            colour=PAPER,
        )


def mesh_chart(coarse: ResponseCurves, fine: ResponseCurves) -> Chart:
    """The true response with 13 and with 21 elements, and their difference in per cent: Fig. 5."""
    one, other = (_true(each) for each in (coarse, fine))
    between = _at_speeds(other, one.speed)
    of = Agreement(one.speed, one.reference, between, one.breaks, ("13 elements", "21 elements"), coarse)
    stacks = []
    for column, channel in enumerate(coarse.channels):
        x = Axis(speed_label(PLAIN), group="speed")
        elements = (
            _line(of, of.reference[:, column], "13 elements", CONTEXT, 4.0, 0.4),
            _line(of, of.other[:, column], "21 elements", MODEL, 1.2),
        )
        above = Panel(elements, x, Axis(amplitude_label(PLAIN), "log", group="amplitude"), channel, 2.4)
        below = Panel(tuple(_differences(of, "identified", column)), x, _difference_axis([of]), height=1.2)
        stacks.append((above, below))
    speed, _, missed = of.worst()
    middle = float(np.nanmedian(of.difference))
    return Chart(
        f"Fig. 5. 21 elements instead of 13 change the response by {_per_cent(middle)} (median over speed), and by {_per_cent(missed)} at {of.said(speed)}",
        "Amplitude of the original response over speed with both meshes, and the difference in per cent of that with 13 elements below.",
        tuple(stacks), len(stacks), 4.6 * max(len(stacks), 2),
    )  # fmt: skip


def _true(curves: ResponseCurves) -> Agreement:
    of = curves.fine if curves.fine is not None and curves.fine.true is not None else curves
    true = as_array(of.true) / vibration_unit(PLAIN)
    return Agreement(as_array(of.speed) / speed_unit(PLAIN), true, true, of.breaks, ("", ""), curves)


def _at_speeds(of: Agreement, speed: Array) -> Array:
    """Amplitudes at other speeds: their logarithms are interpolated by monotone cubics."""
    if np.array_equal(of.speed, speed):
        return of.reference
    order = np.unique(of.speed, return_index=True)[1]
    found = scipy.interpolate.PchipInterpolator(of.speed[order], np.log(of.reference[order]), extrapolate=False)(speed)
    return np.asarray(np.exp(found))
