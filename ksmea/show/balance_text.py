"""A balancing in sentences and tables.

Corrections first, then weights, coefficients, what moves and what does not fit.
"""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.measurement.notation import LAG, Notation
from ksmea.records.balancing import BalanceRecord, EntryRecord, LeftOutRecord, PolarRecord, WeightRecord
from ksmea.show.balance_units import in_units, influence_unit
from ksmea.show.charts.balance_chart import balance_chart
from ksmea.show.charts.picture import drawn
from ksmea.show.readings import PLAIN, deviation_unit, speed_unit
from ksmea.show.text import aligned, number
from ksmea.show.weights_text import ANGLES

__all__ = ["frame", "left_out_frame", "plot", "text"]

MAX_LISTED = 12  # rows that the text lists; the files have all
HOUR = 3600.0
NEGLIGIBLE = 1e-6  # part of a weight that splitting it leaves: rounding
AMPLITUDES = " Phases are not measured: angles of influence coefficients count from the bare response."
OF_COEFFICIENTS = "lag of the vibration from a weight at 0°; from a weight at α it lags by α less"
METHODS = {
    "free": "estimated from the runs, with all its correlations",
    "common": "one factor, from what weights and coefficients leave; speeds and channels count as uncorrelated",
    "stated": "as sigma_um states it; too few runs to test that",
    "repeats": "from repeats only: no further run shows the spread between runs",
    "none": "not known, without interval: no further run, no repeat, no sigma_um",
}


def plot(record: BalanceRecord, axes: Axes | None = None) -> Figure:
    """The response with and without the correction, drift and runs; on given axes the responses alone."""
    return drawn(balance_chart(record), axes)


def text(record: BalanceRecord) -> str:
    """The balancing as an engineer would say it, in the notation of the data."""
    record = in_units(record, record.notation)
    blocks = [_data(record), _correction(record), _weights(record), _coefficients(record), _changes(record)]
    blocks += [_misfits(record), "" if record.left_out is None else _left_out(record.left_out), *record.remarks]
    return "\n\n".join(block for block in blocks if block)


def frame(record: BalanceRecord, notation: Notation = PLAIN) -> pd.DataFrame:
    """Table with a row per entry of the bare response and of each plane's influence coefficients.

    The bare response has no position and is in the unit of vibrations, the coefficients are in that per unit of weights.

    Args:
        record: record of the balancing.
        notation: units and names of channels. Default: µm, phase lead and rpm, as in files.
    """
    record = in_units(record, notation)
    of_planes = ((plane.position, influence_unit(plane.unit, notation), plane.coefficients) for plane in record.planes)
    rows = [(None, deviation_unit(notation), record.bare), *of_planes]
    speed, angle = f"speed_{notation.speed}", _angle(notation)
    names = {"angle_deg": f"{angle}_deg", "angle_low": f"{angle}_low", "angle_high": f"{angle}_high"}
    return pd.DataFrame(
        [
            {
                "position_m": position,
                speed: entry.speed / speed_unit(notation),
                "channel": entry.channel,
                **_polar_columns(value),
                "unit": unit,
            }
            for position, unit, values in rows
            for entry, value in zip(record.entries, values)
        ]
    ).rename(columns=names)


def left_out_frame(weights: tuple[WeightRecord, ...]) -> pd.DataFrame:
    """A row per run and plane: the estimated weight, and the known one next to it."""
    return pd.DataFrame(
        [
            {
                "run": each.run,
                "position_m": each.position,
                **_polar_columns(each.weight),
                "lack_of_fit_p": each.p,
                "known_size": None if each.known is None else each.known.size,
                "known_angle_deg": None if each.known is None else each.known.angle,
                "is_inside": each.is_inside,
                "unit": each.unit,
            }
            for each in weights
        ]
    )


def _polar_columns(value: PolarRecord) -> dict[str, float | None]:
    return {
        "size": value.size,
        "low": value.low,
        "high": value.high,
        "angle_deg": value.angle,
        "angle_low": value.angle_low,
        "angle_high": value.angle_high,
    }


def _data(record: BalanceRecord) -> str:
    dof = "" if record.dof is None or record.dof == 0 else f" ({record.dof:g} complex degrees of freedom)"
    what = "amplitude" if record.is_amplitude else "complex number"
    what += "" if len(record.entries) == 1 else "s"
    planes = "1 plane" if len(record.planes) == 1 else f"{len(record.planes)} planes"
    return (
        f"{record.n_used} of {record.n_run} runs, {len(record.entries)} {what} each (speed × channel), tell {planes}."
        f"{AMPLITUDES if record.is_amplitude else ''}\nCovariance: {METHODS[record.method]}{dof}."
    )


def _correction(record: BalanceRecord) -> str:
    found = record.correction
    lines = [
        [f"{position:g}", found.unit(index), *_cells(weight)]
        for index, (position, weight) in enumerate(zip(found.position, found.weight))
    ]
    table = _in_unit(["plane m", "", _level(record), "angle °", _level(record)], lines, 1)
    said = [f"Correction weights for the bare rotor:\n{table}"]
    said += [f"{ANGLES}."] if record.notation.phase == LAG else []
    said += [_left(record)] if not found.common else [_hardly_determined(record)]
    said += [_in_holes(record)] if found.splits else []
    if found.p is not None:
        fits = found.p >= record.level
        said.append(
            f"The bare response {'can be' if fits else 'is not'} from unbalance in these planes only (p = {found.p:.2g})"
            + (
                ": the bare rotor's unbalance is opposite to the correction."
                if fits
                else ": runout, bow or unbalance elsewhere is a part of it."
            )
        )
    return "\n".join(said)


def _left(record: BalanceRecord) -> str:
    """Residual vibration after the correction.

    No figure if it is 0 by calculation, with as many weights as readings.
    """
    before, after = _root_sum(record.correction.bare), _root_sum(record.correction.left)
    unit = deviation_unit(record.notation)
    if len(record.entries) <= len(record.correction.weight):
        highest = [each.high for each in record.correction.left if each.high is not None]
        within = f"; errors of the readings leave up to {number(max(highest), 3)} {unit}" if highest else ""
        return (
            f"With them the root sum of squares of {number(before, 3)} {unit} becomes 0 by calculation, since weights are as many"
            f" as readings{within}. A run with them shows the remaining vibration."
        )
    worst = max(record.correction.left, key=lambda each: each.size)
    entry = record.entries[record.correction.left.index(worst)]
    ends = "" if worst.low is None else f" ({number(worst.low, 3)} to {number(worst.high, 3)})"
    return (
        f"With them the root sum of squares goes from {number(before, 3)} to {number(after, 3)} {unit}; most is left at"
        f" {_place(entry, record.notation)}: {number(worst.size, 3)} {unit}{ends}."
    )


def _hardly_determined(record: BalanceRecord) -> str:
    """Warning of nearly dependent planes, with the part of the correction that the readings determine."""
    found, unit = record.correction, deviation_unit(record.notation)
    condition = "infinite" if found.condition is None else number(found.condition, 3)
    by = "without limit" if found.condition is None else f"by up to {number(found.condition, 2)} %"
    common = "; ".join(
        f"{number(weight.size, 3)} {found.unit(index)} at {weight.angle:.0f}° at {position:g} m"
        for index, (position, weight) in enumerate(zip(found.position, found.common))
    )
    return (
        f"Warning: the planes are nearly dependent (condition number {condition}): weights in them do almost the same at these"
        f" speeds and probes.\nAn error of 1 % in the readings changes these weights {by}, so the remaining vibration is not"
        f" predicted.\nThe part that the readings do show: {common}; of a root sum of squares of"
        f" {number(_root_sum(found.bare), 3)} {unit} it leaves {number(_root_sum(found.left_common), 2)} {unit} by calculation, and up to"
        " 2 % of it more for each 1 % of error.\nMeasure at"
        " another speed or with another probe, or put weights in one plane alone."
    )


def _in_holes(record: BalanceRecord) -> str:
    found = record.correction
    lines = [
        [f"{each.position:g}", str(weight.hole), f"{weight.angle:.1f}", each.unit, number(weight.size)]
        for each in found.splits
        for weight in each.weights
    ]
    said = [f"In the holes of the planes:\n{_in_unit(['plane m', 'hole', 'angle °', ''], lines, 3)}"]
    for each in found.splits:
        if each.missing.size > NEGLIGIBLE * found.weight[found.position.index(each.position)].size:
            said.append(
                f"Missing at {each.position:g} m: {number(each.missing.size, 3)} {each.unit} at {each.missing.angle:.0f}°."
            )
    if not found.common:
        said.append(
            f"With these the root sum of squares is {number(_root_sum(found.left_split), 3)}"
            f" {deviation_unit(record.notation)} by calculation."
        )
    return "\n".join(said)


def _in_unit(head: list[str], lines: list[list[str]], at: int) -> str:
    """A table whose cells number `at` are units: in the head where all are alike."""
    units = {line[at] for line in lines}
    if len(units) == 1:
        head = [*head[:at], units.pop(), *head[at + 1 :]]
        return aligned(head, [line[:at] + line[at + 1 :] for line in lines])
    return aligned([*head[:at], "unit", "size", *head[at + 1 :]], lines)


def _root_sum(values: tuple[PolarRecord, ...]) -> float:
    return float(sum(each.size**2 for each in values) ** 0.5)


def _weights(record: BalanceRecord) -> str:
    if not record.weights:
        return ""
    lines = [
        [each.run, f"{each.position:g}", each.unit, *_cells(each.weight), f"{each.p:.2g}"]
        for each in record.weights[:MAX_LISTED]
    ]
    head = ["run", "plane m", "", _level(record), "angle °", _level(record), "lack-of-fit p"]
    return f"Unknown weights:\n{_in_unit(head, lines, 2)}{_more(len(record.weights))}"


def _coefficients(record: BalanceRecord) -> str:
    notation = record.notation
    lines = [
        [f"{plane.position:g}", *_entry(entry, notation), influence_unit(plane.unit, notation), *_cells(value)]
        for plane in record.planes
        for entry, value in zip(record.entries, plane.coefficients)
    ]
    head = ["plane m", notation.speed, "channel", "", _level(record), f"{_angle(notation)} °", _level(record)]
    said = f" ({OF_COEFFICIENTS})" if notation.phase == LAG else ""
    return f"Influence coefficients{said}:\n{_in_unit(head, lines[:MAX_LISTED], 3)}{_more(len(lines))}"


def _changes(record: BalanceRecord) -> str:
    """Dependence of the response on other things than weights, and scatter of the runs."""
    said = []
    if record.slope:
        slopes = ", ".join(f"{each:.2f}" for each in record.slope)
        said.append(f"The response grows with the deviation of a run's speed: d ln y / d ln Ω = {slopes}.")
    if record.growth is not None:
        said.append(
            f"Weights do not act in proportion: one of {number(record.growth_scale)} {record.unit} does"
            f" {100 * record.growth:+.3g} % more than small ones say."
        )
    if record.time_constant is not None:
        gained = "" if record.deviance_of_drift is None else f"; deviance drop {record.deviance_of_drift:.0f}"
        said.append(f"Responses drift, with a time constant of {record.time_constant / HOUR:.3g} h{gained}.")
    elif record.deviance_of_drift is not None:
        said.append(f"No drift is needed (deviance drop {record.deviance_of_drift:.0f}).")
    if any(each.spread is not None for each in record.spread):
        lines = [
            [
                *_entry(each.entry, record.notation),
                *(number(value, 3) for value in (each.spread, each.drift, each.repeats)),
                number(each.p, 2),
            ]
            for each in record.spread[:MAX_LISTED]
        ]
        head = [record.notation.speed, "channel", "spread", "drift", "repeats", "p"]
        unit = deviation_unit(record.notation)
        said.append(f"Standard deviations, {unit} (p: runs scatter as repeats do):\n{aligned(head, lines)}")
    return "\n".join(said)


def _misfits(record: BalanceRecord) -> str:
    said = []
    unit = deviation_unit(record.notation) + (f" ({LAG})" if record.notation.phase == LAG else "")
    for each in record.run_misfits:
        weights = "; ".join(
            f"{weight.position:g} m: marked {_shown(weight.known)}, estimated {_shown(weight.weight)} {weight.unit}"
            for weight in each.weights
        )
        rest = each.weights[0].p
        also = " No weights explain it." if rest < record.level / record.n_run else ""
        said.append(f"Run {each.run} does not fit its weights (p = {each.p:.1g}) and was left out. {weights}.{also}")
    for entry in record.entry_misfits:
        said.append(
            f"Run {entry.run}, {_place(entry.entry, record.notation)}: {_shown(entry.measured)} {unit} does not fit"
            f" {entry.beside}, by which it is {_shown(entry.expected)} {unit} (p = {entry.p:.1g}, {entry.n_test} tests)."
        )
    return "\n".join(said)


def _left_out(found: LeftOutRecord) -> str:
    angle = (
        ""
        if found.mean_angle is None
        else (
            f", mean error of angles from {number(found.least_of_angle)} {found.unit} on {number(found.mean_angle, 3)}°"
        )
    )
    return (
        f"Each run predicted by the others: RMSE of sizes {number(found.rms_size, 3)} {found.unit}, mean absolute error"
        f" {number(found.mean_size, 3)} {found.unit}{angle}; {100 * found.coverage:.0f} % of the regions hold the known weight"
        f" ({len(found.weights)} weights)."
    )


def _shown(value: PolarRecord | None) -> str:
    return "–" if value is None else f"{number(value.size, 3)}@{value.angle:.0f}°"


def _place(entry: EntryRecord, notation: Notation) -> str:
    speed, channel = _entry(entry, notation)
    return f"{speed} {notation.speed}, {channel}"


def _entry(entry: EntryRecord, notation: Notation) -> tuple[str, str]:
    """Speed, in the unit of the notation, and channel."""
    return f"{entry.speed / speed_unit(notation):.5g}", entry.channel


def _angle(notation: Notation) -> str:
    """Heading of the angles of vibrations."""
    return LAG if notation.phase == LAG else "angle"


def _cells(value: PolarRecord) -> list[str]:
    size = "–" if value.low is None else f"{number(value.low)} to {number(value.high)}"
    angle = "–" if value.angle_low is None else f"{value.angle_low:.1f} to {value.angle_high:.1f}"
    return [number(value.size), size, f"{value.angle:.1f}", angle]


def _level(record: BalanceRecord) -> str:
    return f"{100 * record.interval_level:g} %"


def _more(n: int) -> str:
    return f"\n(and {n - MAX_LISTED} more)" if n > MAX_LISTED else ""
