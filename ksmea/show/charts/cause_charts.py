"""Pictures of a diagnosis: worst channel with and without the cause, orbit, and noise of other causes.

The orbit may be a polar plot.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.notation import Notation
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.statement import ORBIT
from ksmea.show import diagnosis_findings as findings
from ksmea.show.charts.chart import (
    Axis,
    Chart,
    Element,
    Line,
    Panel,
    Points,
    Span,
    Words,
    broken,
    named_rows,
    one_panel,
)
from ksmea.show.charts.colours import AFTER, ALIKE, BEFORE, CONTEXT, MEASURED, MODEL
from ksmea.show.charts.parts.bode import N_SD, residual_ground, residual_reach
from ksmea.show.charts.parts.polar import FULL_TURN, REACH, phase_in_words, rings, speeds_at, speeds_said, within
from ksmea.show.charts.response_charts import SYMBOLS, legend_of
from ksmea.show.charts.responses import ACCEPTED, AS_GIVEN, WITH_CAUSE, Response, of_diagnosis
from ksmea.show.readings import PLAIN, speed_digits, speed_form, speed_label, speed_unit

MOST_OTHERS = 8  # causes that the picture of noise shows
ROW = 0.32  # inches of each
STYLES = {AS_GIVEN: (BEFORE, "dash"), WITH_CAUSE: (AFTER, "solid"), ACCEPTED: (MODEL, "solid")}
ORBIT_ROOM = 1.15  # times the farthest point of an orbit: where axes end


def worst_channel(record: DiagnosisRecord, response: Response) -> int:
    """The channel in which most of the misfit of the model as given sits."""
    name = record.lack_of_fit.before.channel
    return response.channels.index(name) if name in response.channels else 0


def response_chart(record: DiagnosisRecord, notation: Notation = PLAIN) -> Chart | None:
    """Amplitude of the worst channel over speed, measured and by both models.

    Below it what the accepted model leaves, in σ.
    """
    response = of_diagnosis(record, notation)
    if response is None:
        return None
    column = worst_channel(record, response)
    x = Axis(speed_label(notation), group="speed")
    elements: list[Element] = []
    if record.is_rejected:
        low, high = (end / speed_unit(notation) for end in record.lack_of_fit.before.band)
        elements.append(Span(low=low, high=high, along="x", colour=BEFORE, opacity=0.1))
    for model, curve in response.curves.items():
        colour, dash = STYLES[model]
        amplitude = broken(np.abs(curve.values[:, column]), curve.breaks)
        elements.append(Line(broken(curve.speed, curve.breaks), amplitude, dash, 1.4, name=model, colour=colour))
    measured = np.abs(response.measured[:, column])
    elements.append(Points(response.speed, measured, size=3.5, name="measured", colour=MEASURED))
    name = response.shown_channels[column]
    panels = [Panel(tuple(elements), x, Axis(f"{name}, {notation.unit}", "log"), height=2.6)]
    accepted = next(reversed(tuple(response.residuals)), "")
    if accepted:
        parts = response.residuals[accepted]
        panels.append(_residuals({part: left[:, column] for part, left in parts.items()}, response, x))
    left = (
        f"; below: residuals of the model{'' if accepted == ACCEPTED else f' {accepted}'} in σ of the noise"
        f"{legend_of(response.residuals[accepted])}, ± {N_SD:g} shaded"
        if accepted
        else ""
    )
    title = f"Response of {name}, measured and by the model"
    if record.is_rejected:
        title = f"Largest misfit of the model as given: {findings.where(record.lack_of_fit.before, notation)}"
        left = f"; shaded: the largest misfit, in σ of the noise{left}"
    return Chart(title, f"Dots: measured{left}.", (tuple(panels),), width=6.5)


def _residuals(parts: dict[str, Array], response: Response, x: Axis) -> Panel:
    most = residual_reach(parts)
    elements: list[Element] = list(residual_ground(parts, most, float(np.max(response.speed))))
    for (part, left), symbol in zip(parts.items(), SYMBOLS):
        said = f"{{x:{speed_form(response.notation)}}}: {{y:.2f}} σ ({part})"
        elements.append(Points(response.speed, left, symbol, 3.0, colour=CONTEXT, said=said))
    return Panel(tuple(elements), x, Axis("residual / σ", low=-most, high=most), height=1.1)


def cause_chart(record: DiagnosisRecord, notation: Notation = PLAIN) -> Chart | None:
    """The picture that shows the cause best; None of amplitudes, which have no phase to draw."""
    response = of_diagnosis(record, notation)
    if response is None or not response.has_phase:
        return None
    stated = [effect.statement for effect in record.applied if effect.statement is not None]
    if stated and stated[0].picture == ORBIT and response.planes():
        return orbit_chart(record, response)
    return polar_chart(record, response)


def polar_chart(record: DiagnosisRecord, response: Response) -> Chart:
    """The response of the worst channel in the complex plane, with speeds at some points."""
    column, notation = worst_channel(record, response), response.notation
    measured = response.measured[:, column]
    reach = float(np.max(np.abs(measured)))
    said = speeds_said(response.speed, notation)
    speeds = list(speeds_at(measured, said))
    elements = list(rings(reach, notation, speeds))
    for model, curve in response.curves.items():
        colour, dash = STYLES[model]
        values = within(curve.values[:, column], reach)
        re, im = (broken(part, curve.breaks) for part in (values.real, values.imag))
        elements.append(Line(re, im, dash, 1.4, name=model, colour=colour))
    elements.append(Points(measured.real, measured.imag, size=3.5, name="measured", colour=MEASURED, said=said))
    elements += speeds
    name = response.shown_channels[column]
    axis = Axis(low=-REACH * reach, high=REACH * reach, ticks={})
    return one_panel(
        elements, axis, axis, f"{name} in the complex plane",
        f"{notation.unit}; {phase_in_words(notation)}; numbers: speed in {notation.speed}.",
        height=3.7, is_to_scale=True, width=4.6,
    )  # fmt: skip


def orbit_chart(record: DiagnosisRecord, response: Response) -> Chart:
    """The orbit of the plane, and at the speed, at which the model as given differs most from the data."""
    notation = response.notation
    found: tuple[float, str, int] | None = None
    given = response.at_speeds[AS_GIVEN]
    for place, (columns, to_xy) in response.planes().items():
        misfit = np.linalg.norm((response.measured - given)[:, list(columns)] @ to_xy.T, axis=1)
        at = int(np.argmax(misfit))
        found = max(found or (-1.0, "", 0), (float(misfit[at]), place, at))
    assert found is not None, "a response without planes"
    _, place, at = found
    columns, to_xy = response.planes()[place]
    elements: list[Element] = []
    reach = 0.0
    for name, values in {"measured": response.measured, **response.at_speeds}.items():
        x, y = _orbit(to_xy @ values[at, list(columns)])
        reach = max(reach, ORBIT_ROOM * float(np.max(np.abs([x, y]))))
        colour, dash = STYLES.get(name, (MEASURED, "dot"))
        width = 2.4 if name == "measured" else 1.4
        elements.append(Line(x, y, dash, width, name=name, colour=colour))
        elements.append(Points([x[0]], [y[0]], size=5.0, colour=colour, said="phase mark"))
    speed = f"{speed_digits(float(response.speed[at]), notation)} {notation.speed}"
    return one_panel(
        elements, Axis(f"x, {notation.amplitude}", low=-reach, high=reach), Axis(f"y, {notation.amplitude}", low=-reach, high=reach),
        f"Orbit at {response.plane_name(place)}, {speed}",
        f"Path of the shaft at the largest difference in {notation.amplitude}, model as given; dots: at the phase mark.",
        height=3.7, is_to_scale=True, width=4.6,
    )  # fmt: skip


def others_chart(record: DiagnosisRecord) -> Chart | None:
    """Noise that each explanation of the data needs, as a multiple of what the best one needs."""
    all_others = findings.others(record)
    others = all_others[:MOST_OTHERS]
    given = findings.as_given(record)
    if not others or given is None:
        return None
    best = " with ".join(_words(record))
    every = [(best, 1.0, f"{findings.TIMES} 1", MODEL, "circle")]
    every += [(each.words, each.multiple, _said(each), ALIKE if each.is_near else CONTEXT, "circle") for each in others]
    every.append(("model as given", given, f"{findings.TIMES} {given:.3g}", BEFORE, "diamond"))
    elements: list[Element] = [
        Points([multiple], [float(at)], symbol, 7.0, colour=colour, said=f"{name}: {multiple:.3g} times the noise")
        for at, (name, multiple, _, colour, symbol) in enumerate(every)
    ]
    elements += [
        Words(x=multiple, y=float(at), text=said, offset=(8.0, 0.0), side="left", size=9.0)
        for at, (_, multiple, said, _, _) in enumerate(every)
    ]
    most = max(multiple for _, multiple, *_ in every)
    n_near = sum(each.is_near for each in others)
    title = (
        f"{n_near + 1} causes explain the data about as well"
        if n_near
        else "No other known cause explains the data as well"
    )
    is_cut = len(all_others) > len(others)
    of_which = f"; the best {len(others)} of {len(all_others)} other causes" if is_cut else ""
    return one_panel(
        elements, Axis("noise needed (best: 1)", "log", low=0.9, high=2.2 * max(most, 1.2)),
        named_rows(name for name, *_ in every), title,
        f"Noise that each cause needs to explain the data, relative to the best one (logarithmic), at its best location; in brackets: odds"
        f" against it{of_which}.",
        height=ROW * len(every) + 0.3, width=6.5,
    )  # fmt: skip


def _said(other: findings.Other) -> str:
    """The noise that a cause needs, and the odds against it if that is hardly more: '× 1.02 (8 100 : 1)'."""
    noise = f"{findings.TIMES} {other.multiple:.3g}"
    if other.is_near or other.multiple >= findings.FAR:
        return noise
    return f"{noise} ({findings.odds(other.behind, at_most='> 10⁶')} : 1)"


def _words(record: DiagnosisRecord) -> Iterator[str]:
    for effect in record.applied:
        yield effect.statement.words if effect.statement is not None else effect.name.replace("_", " ")


def _orbit(phasors: ComplexArray) -> tuple[Array, Array]:
    """Path (x, y) over one turn of two phasors (2,)."""
    moving = np.real(np.asarray(phasors)[:, None] * np.exp(1j * FULL_TURN))
    return moving[0], moving[1]
