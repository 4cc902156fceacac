"""An identification as sentences, a table, and a figure of data, fit and residuals over speed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.errors import SettingError
from ksmea.measurement.notation import Notation
from ksmea.records.curves import as_array
from ksmea.records.identification import DataDescription, IdentificationRecord, ParameterRecord
from ksmea.records.location import LocationRecord
from ksmea.show import inputs_text, location_text, weights_text
from ksmea.show.charts.chart import Chart
from ksmea.show.charts.picture import drawn
from ksmea.show.charts.response_charts import bode_chart
from ksmea.show.charts.responses import of_fit
from ksmea.show.readings import deviation_unit, vibration_unit
from ksmea.show.statements import value_columns
from ksmea.show.text import (
    ALIKE,
    alike_text,
    capital,
    data_words,
    fit_verdict,
    hausman_lines,
    hidden_text,
    noise_parts,
    number,
    repeat_lines,
    rounded_alike,
    stability_text,
    two_digits,
    value_and_ends,
)
from ksmea.units import DEGREE

SLIGHT = 0.1  # parts of the noise below this part of the whole everywhere are not mentioned
COLUMNS = ("parameter", "unit", "value", "low", "high", "kind", "crlb", "at_limit", "search_end")


def text(record: IdentificationRecord, title: str = "", *, with_values: bool = True) -> str:
    """Text of an identification: values with intervals, undetermined unknowns, noise, and fit.

    There is a line for each, below a title and the data; values may be left out. A hidden effect of synthetic data follows.
    """
    found = "\n".join(_lines(record, title, with_values=with_values))
    beside = [] if record.location is None else [location_text.text(record.location), *_why_without(record.location)]
    return "\n\n".join(filter(None, [found, *beside, hidden_text(record.hidden, "identification")]))


def _why_without(found: LocationRecord) -> list[str]:
    return [] if found.force is None else [location_text.why_without("those identified")]


def residual_frame(record: IdentificationRecord) -> pd.DataFrame:
    """A row per speed and channel.

    Data and fitted response (µm 0-peak, degrees of lead), residuals in standard deviations of the noise. Raises
    `SettingError` if the record has no fit.
    """
    if record.fit is None:
        raise SettingError("residuals: expected an identification with its fit, got a record without; identify again")
    response = of_fit(record.fit)
    columns: dict[str, Any] = {
        "speed_rpm": response.speed[:, None],
        "channel": np.array(response.channels, dtype=object),
    }
    for name, values in (("measured", response.measured), ("fitted", response.at_speeds["fitted"])):
        columns[f"{name}_um_0pk"] = np.abs(values)
        if response.has_phase:
            columns[f"{name}_lead_deg"] = np.angle(values) / DEGREE
    for part, residuals in response.residuals.get("fitted", {}).items():
        columns[f"residual_{part.replace(' ', '_')}_sd"] = residuals
    shape = response.measured.shape
    return pd.DataFrame({name: np.broadcast_to(each, shape).ravel() for name, each in columns.items()})


def frame(record: IdentificationRecord) -> pd.DataFrame:
    """A row per parameter, in its unit.

    `low` and `high` are empty if the data leave that side open, `kind` says how the interval was made, `crlb` is the
    Cramér–Rao bound (1 σ) at the values, `search_end` is the value at which the method stopped. With a location, also
    the values estimated with the unknown quantity, over all accepted sites.
    """
    rows = [
        (
            *(part.name, part.unit),
            *(part.in_unit(value) for value in (part.value, part.low, part.high)),
            *(part.kind, part.in_unit(part.crlb), part.at_limit, part.in_unit(part.identified)),
        )
        for part in record.parameters
    ]
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    if record.weights is not None:
        table = pd.concat([table, weights_text.frame(record.weights).assign(at_limit=False)], ignore_index=True)
    if record.location is None:
        return table
    beside = [each.over_sites for each in record.location.coefficients]
    return table.assign(
        **{
            f"{name}_beside": [
                np.nan if each is None or (value := getattr(each, name)) is None else value for each in beside
            ]
            for name in ("value", "low", "high")
        }
    )


def value_table(record: IdentificationRecord) -> pd.DataFrame:
    """Unknowns in brief: value, interval, relative half-width and unit.

    Of a rejected model, and without intervals, values alone.
    """
    test = record.lack_of_fit
    rows = []
    for part in record.parameters:
        value, interval, relative = value_columns(part.shown)
        known = {}
        if record.intervals is not None and not (test is not None and test.rejected):
            interval = "–" if part.kind is None else interval
            known = {f"{100 * record.intervals.level:g} %": interval, "±": relative}
        rows.append({"": part.name, "value": value, **known, "unit": part.unit})
    return pd.DataFrame(rows)


def table(record: IdentificationRecord) -> pd.DataFrame:
    """Table of the estimates for readers: each number rounded to what its interval warrants.

    '–' if it does not exist.
    """
    found = frame(record)
    shown = pd.DataFrame({"unknown": found["parameter"], **_in_columns(found, ""), "unit": found["unit"]})
    if "value_beside" in found:
        beside = _in_columns(found, "_beside")
        shown = shown.assign(**{"with an unknown force": beside["value"], "its interval": beside["interval"]})
    rows = found.to_dict("records")
    ends = [rounded_alike(row["search_end"], row["low"], row["high"])[0] for row in rows]
    at_limit = ["yes" if row["at_limit"] else "no" for row in rows]
    bounds = [number(row["crlb"], 2) for row in rows]
    return shown.assign(
        kind=found["kind"].fillna("–"), **{"CRLB (1 σ)": bounds, "at limit": at_limit, "search end": ends}
    )


def _in_columns(found: pd.DataFrame, suffix: str) -> dict[str, list[str]]:
    """Values and intervals; of one that is open on both sides '–'."""
    rows = found[[f"{name}{suffix}" for name in ("value", "low", "high")]].to_numpy(float)
    cells = [value_and_ends(*row) for row in rows]
    is_open = np.isnan(rows[:, 1:]).all(axis=1)
    return {
        "value": [value for value, _ in cells],
        "interval": ["–" if none else ends for (_, ends), none in zip(cells, is_open)],
    }


def plot(record: IdentificationRecord, axes: Axes | None = None, title: str = "") -> Figure:
    """Data and fit of a record with details.

    A figure of all channels with amplitudes, phases where there are any, and residuals. On given axes the amplitude of
    the first channel alone.
    """
    if record.fit is None:
        raise SettingError("plot: expected a record with data and fit, got none; identify with details=True")
    made = drawn(identification_chart(record, title), axes)
    if axes is not None and title:
        axes.set_title(title, fontsize=10)
    return made


def identification_chart(record: IdentificationRecord, title: str = "") -> Chart:
    """Data, fit and residuals over speed."""
    assert record.fit is not None, "a record without details"
    verdict = "" if record.lack_of_fit is None else capital(fit_verdict(record.lack_of_fit).removeprefix("fit: "))
    response = of_fit(record.fit, notation=record.notation)
    return bode_chart(response, ": ".join(filter(None, [title, verdict])) or "Response over speed")


def _lines(record: IdentificationRecord, title: str, *, with_values: bool) -> Iterator[str]:
    head = [title] if title else []
    head += [] if record.data is None else [_data_text(record.data, record.notation)]
    if head:
        yield ": ".join(head)
    if record.data is not None:
        yield from (f"  note: {remark}" for remark in record.data.remarks)
    yield from (f"  note: {remark}" for remark in record.remarks)
    for parameter in record.parameters if with_values else ():
        yield f"  {_value_text(record, parameter)}"
    if record.weights is not None:
        yield from weights_text.lines(record.weights, record.notation)
    if record.ended_short:
        yield _search_text(record)
    yield from inputs_text.lines(record.inputs, record.parameters)
    if record.interval_error is not None:
        yield f"no intervals: {record.interval_error}"
    yield from _noise_text(record)
    yield from repeat_lines(record.repeats, record.notation)
    yield from hausman_lines(record.both_ways)
    yield f"strongly correlated parameters (|r| > {ALIKE}): {_alike_text(record)}"
    yield from stability_text(record.stability, record.notation)
    if record.lack_of_fit is not None:
        yield fit_verdict(record.lack_of_fit)
    elif record.data is not None and record.data.too_few_to_test:
        yield "too few data to test the fit: with less than two per unknown it follows whatever was measured"


def _data_text(data: DataDescription, notation: Notation) -> str:
    with_phase = data.kind == "complex"
    return data_words(data.n_speed, data.speed_from, data.speed_to, data.channels, notation, with_phase=with_phase)


def _value_text(record: IdentificationRecord, parameter: ParameterRecord) -> str:
    """For example 'kxx = 50.03 MN/m, 95 % interval [49.92, 50.14]'."""
    name, unit = parameter.name, parameter.unit
    value, low, high = (parameter.in_unit(end) for end in (parameter.value, parameter.low, parameter.high))
    at, least, most = rounded_alike(value, low, high)
    level = f"{100 * (0.95 if record.intervals is None else record.intervals.level):g} %"
    best = f"{at} {unit}"
    if parameter.kind is None:
        said = f"{name} = {best}"
    elif parameter.kind == "not identifiable" and record.data is not None and record.data.reference:
        return f"{name}: not known from differences: what is alike in all runs cancels"
    elif parameter.kind == "not identifiable":
        return f"{name}: not identifiable from these data: any value of the search fits about as well"
    elif np.isnan(low):
        said = f"{name}: at most {most} {unit} ({level}; best fit {best})"
    elif np.isnan(high):
        said = f"{name}: at least {least} {unit} ({level}; best fit {best})"
    else:
        said = f"{name} = {best}, {level} interval [{least}, {most}]"
        said += ", of which some between do not fit" if parameter.kind == "hull" else ""
    return said + ("; best fit at a limit of its search (problem.limits)" if parameter.at_limit else "")


def _search_text(record: IdentificationRecord) -> str:
    """Values at which the method stopped, for unknowns whose reported value differs from that."""
    ends = ", ".join(
        f"{part.name} = {rounded_alike(*(part.in_unit(value) for value in (part.identified, part.low, part.high)))[0]} {part.unit}"
        for part in record.parameters
        if part.ended_short
    )
    higher = "" if record.search_excess is None else f", with a deviance {number(record.search_excess, 3)} higher"
    return f"search ended short: the method stopped at {ends}{higher}; the values above are at the maximum of the likelihood"


def _noise_text(record: IdentificationRecord) -> Iterator[str]:
    """The noise in words: estimated, or as stated."""
    if record.intervals is None:
        return
    noise, notation = record.intervals.noise, record.notation
    if noise.by_run:
        said = "; ".join(
            f"{name} {noise_parts(*_telling_parts(record, *level), notation)}" for name, *level in noise.by_run
        )
        yield f"noise {'estimated' if noise.estimated else 'as stated'} run by run: {said}"
    elif noise.estimated:
        yield f"noise, estimated: {noise_parts(*_telling_parts(record, noise.relative, noise.floor), notation)}"
    elif noise.relative == 0:
        floor = two_digits(noise.floor / vibration_unit(notation))
        yield f"noise as stated datum by datum: {floor} {deviation_unit(notation)} (root mean square)"
    else:
        yield f"noise as stated: {noise_parts(noise.relative, noise.floor, notation)}"


def _telling_parts(record: IdentificationRecord, relative: float, floor: float) -> tuple[float, float]:
    """The two parts of the noise, zero for one that is negligible compared with the other at every speed."""
    if record.fit is None:
        return relative, floor
    amplitude = as_array(record.fit.fitted.amplitude)
    if relative * amplitude.max() < SLIGHT * floor:
        return 0.0, floor
    return relative, 0.0 if floor < SLIGHT * relative * amplitude.min() else floor


def _alike_text(record: IdentificationRecord) -> str:
    if record.correlation is None:
        return "not computed, without noise"
    return alike_text(record.correlation, [parameter.name for parameter in record.parameters])
