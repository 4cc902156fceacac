"""A diagnosis as sentences, tables and figures."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.errors import SettingError
from ksmea.records.diagnosis import CurvesRecord, DiagnosisRecord, TrialRecord
from ksmea.records.estimate import NoiseLevelRecord
from ksmea.records.location import NOTHING
from ksmea.show import diagnosis_findings as findings
from ksmea.show import inputs_text, location_text
from ksmea.show.charts.chart import Chart
from ksmea.show.charts.picture import drawn
from ksmea.show.charts.ranking_chart import ranking_chart
from ksmea.show.charts.response_charts import bode_chart
from ksmea.show.charts.responses import AS_GIVEN, WITH_CAUSE, of_diagnosis
from ksmea.show.diagnosis_findings import alike, applied, verdict_line
from ksmea.show.diagnosis_notes import notes
from ksmea.show.diagnosis_tables import (
    averaged_values,
    ranking_table,
    unknowns_table,
    values_beside,
    values_of_rejected,
)
from ksmea.show.location_words import in_short, over_the_shaft
from ksmea.show.text import (
    aligned,
    capital,
    data_words,
    gain_lines,
    hausman_lines,
    hidden_text,
    in_columns,
    noise_level,
    number,
    repeat_lines,
    stability_text,
    with_ends,
)

BEFORE = f'those "{AS_GIVEN}"'
AFTER = f'those "{WITH_CAUSE}", of the extended model'
MAX_LOCATIONS = 4  # listed, at which an effect explains the data about as well
AVERAGED = 'those "averaged", over all that explain the data about as well'
MAX_RANKED = 6  # effects that the text lists
FEWEST_TO_LOCATE = 3  # channels: an unknown force takes two at each speed


def text(record: DiagnosisRecord) -> str:
    """Diagnosis as text: finding, certainty, checks, evidence, and hidden effects of synthetic data."""
    blocks = [_finding(record), notes(record), evidence(record), hidden_text(record.hidden, "diagnosis")]
    return "\n\n".join(block for block in blocks if block)


def _finding(record: DiagnosisRecord) -> str:
    """Title, meaning, certainty, checks and look-alikes, in the notation of the data."""
    notation = record.notation
    lines = [f"{findings.title(record, notation)}.", findings.meaning(record, notation)]
    lines += [f"  {value}: {said}" for value, said in findings.certainty(record, notation)]
    lines += [f"Check: {advice}" for advice in findings.checks(record)]
    return "\n".join([*lines, *findings.look_alikes(record)])


def evidence(record: DiagnosisRecord) -> str:
    """All that the finding rests on."""
    blocks = [
        _data(record),
        _sentence(repeat_lines(record.repeats, record.notation)),
        _sentence(hausman_lines(record.both_ways)),
        _what_is_wrong(record),
        _unknowns(record),
        inputs_text.text(record.inputs),
        _cause(record),
        *values_beside(record),
        _predictive_gain(record),
        values_of_rejected(record),
        _location(record),
        _detectable(record),
        "\n".join(stability_text(record.stability, record.notation)),
        _left_out(record),
    ]
    return "\n\n".join(block for block in blocks if block)


def _sentence(lines: Iterable[str]) -> str:
    return "\n".join(f"{capital(line)}." for line in lines)


def about_extension(record: DiagnosisRecord) -> list[str]:
    """Head of the file of the extended model.

    It states whether the model is one of several that fit about as well and the measurement that would distinguish
    them, the data that it was fitted to, and its effects with their sizes.
    """
    if record.verdict == "located" and record.location is not None:
        return location_text.about_extension(record.location)
    lines = []
    if record.verdict == "ambiguous":
        lines += ["One of several models: the diagnosis is ambiguous.", *_split(record)]
    data = f'the measurement "{record.source}"' if record.source else "a measurement"
    lines.append(f"This file holds {applied(record)}, fitted to {data}:")
    lines += [
        f"  {row.name} = {with_ends(row.after.value, row.after.low, row.after.high)} {row.after.unit}"
        for row in record.coefficients
        if row.before is None and row.after is not None
    ]
    return lines + _locations(record)


def frame(record: DiagnosisRecord) -> pd.DataFrame:
    """Ranked effects, a row per unknown of each effect and location; in `unit`, NaN if an end is open."""
    rows = [
        {
            "rank": rank,
            "effect": trial.effect,
            "location": trial.location,
            "deviance_drop": trial.deviance_drop,
            "delta_bic": trial.delta_bic,
            "p": trial.p,
            "unknown": part.name,
            "size": part.value,
            "low": part.low,
            "high": part.high,
            "unit": part.unit,
            "interval": part.interval,
            "at_limit": part.at_limit,
        }
        for rank, trial in enumerate(record.ranking, start=1)
        for part in trial.parameters
    ]
    return pd.DataFrame(rows).astype({"low": float, "high": float})


def coefficients_frame(record: DiagnosisRecord) -> pd.DataFrame:
    """Table of unknowns before and after the extension and averaged, with intervals, in `unit`."""
    rows, averaged = [], averaged_values(record)
    columns = ("before", "after", "averaged") if averaged else ("before", "after")
    for coefficient in record.coefficients:
        row: dict[str, str | float] = {"unknown": coefficient.name, "unit": ""}
        mean = averaged.get(coefficient.name)
        for when, estimated in zip(columns, (coefficient.before, coefficient.after, mean)):
            value, low, high = (None,) * 3 if estimated is None else (estimated.value, estimated.low, estimated.high)
            for name, part in ((when, value), (f"{when}_low", low), (f"{when}_high", high)):
                row[name] = np.nan if part is None else part
            row["unit"] = row["unit"] if estimated is None else estimated.unit
        rows.append(row)
    return pd.DataFrame(rows)


def plot(record: DiagnosisRecord, axes: Axes | None = None) -> Figure:
    """The residual figure; or, if axes are given, the ranking of effects on them."""
    return drawn(diagnosis_chart(record) if axes is None else ranking_chart(record), axes)


def diagnosis_chart(record: DiagnosisRecord) -> Chart:
    """Stack per channel: amplitudes, and residuals of both models in units of one law of noise."""
    response = of_diagnosis(record, record.notation)
    if response is None:
        raise SettingError(
            "residuals of a diagnosis: expected a record with its curves, got one without (diagnosis.json leaves them out);"
            " draw the record of the run, or give axes to draw the ranking of effects"
        )
    return bode_chart(response, findings.title(record, record.notation))


def _data(record: DiagnosisRecord) -> str:
    """The measurement in a line; '' in a record that keeps no curves."""
    curves = record.curves
    if curves is None:
        return ""
    speeds = len(curves.speed), min(curves.speed), max(curves.speed)
    described = data_words(*speeds, curves.channels, record.notation, with_phase=_has_phase(curves))
    return f"Data: {f'{record.source}, ' if record.source else ''}{described}."


def _has_phase(curves: CurvesRecord) -> bool:
    return isinstance(curves.responses.measured[0][0], tuple)


def _what_is_wrong(record: DiagnosisRecord) -> str:
    before = record.lack_of_fit.before
    said = findings.chance(before)
    if before.p >= record.lack_of_fit.level:
        yet = ", but an effect explains the data better" if record.applied else ""
        return f"The residuals of the model as given are consistent with noise ({said}){yet}.\n{_noise(record)}"
    where = findings.where(before, record.notation)
    lines = [f"The model does not fit: its residuals are not noise ({said}). They are largest {where}."]
    for position, (forward, backward) in before.whirl.items():
        if max(forward, backward) > 2 * min(forward, backward):
            direction, other = ("forward", "backward") if forward > backward else ("backward", "forward")
            ratio = np.sqrt(max(forward, backward) / max(min(forward, backward), 1e-12))
            lines.append(f"Residuals at {position} m: {direction} whirl, {ratio:.2g} times the {other} amplitude.")
    return "\n".join([*lines, _noise(record)])


def _noise(record: DiagnosisRecord) -> str:
    if record.noise.by_datum:
        return "Noise: as stated datum by datum."
    said = "known" if record.noise.known else f"estimated{_by_which_model(record)}"
    return f"Noise ({said}): {noise_level(believed_noise(record), record.notation)}."


def _by_which_model(record: DiagnosisRecord) -> str:
    """Words for the model with which the noise is estimated; empty if it is the model as given."""
    if record.verdict == "located" and record.location is not None:
        return " with the unknown force"
    return f" with {applied(record)}" if record.is_explained and record.noise.after is not None else ""


def believed_noise(record: DiagnosisRecord) -> NoiseLevelRecord:
    """Noise under the model that the verdict accepts, or with an unknown force."""
    if record.verdict == "located" and record.location is not None:
        return record.location.noise
    noise = record.noise
    return noise.after if record.is_explained and noise.after is not None else noise.before


def _cause(record: DiagnosisRecord) -> str:
    names = applied(record)
    lines = [verdict_line(record), *_locations(record)]
    if record.verdict == "misread":
        return "\n\n".join([verdict_line(record), in_columns(unknowns_table(record))])
    if record.verdict == "located":
        lines = [verdict_line(record), *_not_in_library(record, names)]
    if record.verdict == "ambiguous":
        lines += _split(record)
    if record.verdict == "unknown":
        lines += [*_not_in_library(record, names), *_where_to_look(record)]
    elif record.is_explained:
        lines += [
            f"  {name} lies on its physical limit: a part that acts much like it is possible, too"
            for name in findings.at_limits(record)
        ]
    return "\n\n".join(filter(None, ["\n".join(lines), _ranking(record)]))


def _locations(record: DiagnosisRecord) -> list[str]:
    places, others = record.locations[:MAX_LOCATIONS], len(record.locations) - MAX_LOCATIONS
    more = f" or {others} others" if others > 0 else ""
    return [f"The location is not certain: {' or '.join(places)}{more}."] if len(places) > 1 else []


def _split(record: DiagnosisRecord) -> list[str]:
    said = [f"These explain the data about as well: {', '.join(alike(record))}."]
    split = record.split
    if not record.is_split_sought:
        return said
    if split is None:
        return [*said, "None of the measurements that were considered would tell them apart."]
    not_separated = (
        f", but not {' nor '.join(f'{one} from {other}' for one, other in split.together)}" if split.together else ""
    )
    expected = f"(expected Δχ² at least {split.then:.3g}, now {split.now:.3g})"
    return [*said, f"{split.measurement} would tell them apart {expected}{not_separated}."]


def _not_in_library(record: DiagnosisRecord, names: str) -> list[str]:
    after = record.lack_of_fit.after
    if after is None:
        if any(trial.p < record.lack_of_fit.level for trial in record.ranking):  # the remarks say which was given up
            return [
                "The model is wrong, and an unknown cause explains the data as well as the known effects, or better."
            ]
        significant = "is significant" if record.effects else "was tried"
        return [f"The model is wrong, and no known effect {significant}."]
    left = f"its residuals ({findings.chance(after)}) are largest {findings.where(after, record.notation)}"
    return [
        "The model is wrong, and neither one of the known effects nor the best pairs of them leave only noise.",
        f"The nearest is {names}; {left}.",
    ]


def _where_to_look(record: DiagnosisRecord) -> list[str]:
    """Advice to locate the cause with complex data that over-determine an unknown force; empty if located."""
    if record.location is not None:
        return []
    curves = record.curves
    if curves is not None and _has_phase(curves) and len(curves.channels) >= FEWEST_TO_LOCATE:
        return ["+experiment=locate tells at which places of the shaft something acts, whatever it is."]
    return [
        f"Amplitudes and phases of {FEWEST_TO_LOCATE} channels or more would tell at which places something acts (+experiment=locate)."
    ]


def _location(record: DiagnosisRecord) -> str:
    """Findings without the library; if effects are named, in short, as a second opinion."""
    found = record.location
    if found is None:
        return ""
    if not record.is_explained:
        values = [] if record.verdict == "located" else location_text.coefficients(found)
        return "Without the library:\n" + "\n\n".join([*location_text.findings_without_values(found), *values])
    if found.kind == NOTHING:
        said = "nothing is missing in the model"
    elif found.sites and not found.is_anywhere:
        said = f"an unknown {in_short(found)} explains the data too"
    else:
        spread = f"something unknown explains the data too, {over_the_shaft(found)}"
        said = spread if found.sites else "nothing at one place explains the data"
    values = [] if values_beside(record) else location_text.coefficients(found)
    return "\n".join([f"Without the library: {said}.", *values, *why_without(record)])


def why_without(record: DiagnosisRecord) -> list[str]:
    """Reason why unknowns without a location's unknown force differ, and which values to trust.

    With a named cause these are the values of the extended model, without one the values estimated with the unknown force.
    """
    if record.location is None or record.location.force is None:
        return []
    if record.is_explained:
        return [location_text.why_without(BEFORE, AVERAGED if averaged_values(record) else AFTER)]
    return [location_text.why_without(BEFORE)]


def _listed(record: DiagnosisRecord) -> list[TrialRecord]:
    """Best location of the highest-ranked effects, and of effects named, applied or about as good."""
    best: dict[str, TrialRecord] = {}
    for trial in record.ranking:
        best.setdefault(trial.effect, trial)
    meant = [best[name] for name in (*record.named, *record.ambiguity_group) if name in best]
    places = {(effect.name, effect.location) for effect in record.applied}
    meant += [trial for trial in record.ranking if (trial.effect, trial.location) in places]
    listed = {(each.effect, each.location) for each in [*list(best.values())[:MAX_RANKED], *meant]}
    return [trial for trial in record.ranking if (trial.effect, trial.location) in listed]


def _ranking(record: DiagnosisRecord) -> str:
    """Highest-ranked effects with their evidence; sizes have intervals only if a model is accepted."""
    if not record.ranking:
        return ""
    table = in_columns(ranking_table(_listed(record), with_intervals=not record.is_unexplained))
    if record.verdict != "adequate":
        return table
    return f"The model explains the data. The effects that come nearest to being needed:\n{table}"


def _predictive_gain(record: DiagnosisRecord) -> str:
    gain = record.predictive_gain
    if gain is None or not record.is_explained:
        return ""
    meaning = [] if gain.is_supported else [_not_confirmed(record)]
    return "\n".join(
        [*gain_lines(gain, record.notation), *meaning, "", *_weights(record), in_columns(unknowns_table(record))]
    )


def _not_confirmed(record: DiagnosisRecord) -> str:
    """Meaning of an effect that all data require, but the prediction of left-out data does not confirm."""
    return (
        f"The verdict is of all the data: fitted to all of them, the model needs {applied(record)}. Fitted to a part of them, the"
        " extended model does not predict the others surely better: few speeds may show the effect, or it may stand for"
        " something like it. Measure a further run and diagnose all together (measurement=campaign) before you act on it."
    )


def _unknowns(record: DiagnosisRecord) -> str:
    """Unknowns of a model that explains the data without an effect (with one, see `_predictive_gain`)."""
    has_any = any(row.before is not None for row in record.coefficients)
    return in_columns(unknowns_table(record)) if record.verdict in ("adequate", "not observable") and has_any else ""


def _weights(record: DiagnosisRecord) -> list[str]:
    """Explanations over which values are averaged, with their weights."""
    shares: dict[str, float] = {}
    for each in record.explanations:
        if each.weight is not None:
            shares[each.label] = shares.get(each.label, 0.0) + each.weight
    said = ", ".join(f"{label} {share:.2f}" for label, share in shares.items())
    return [f"Averaged over all that explain the data about as well, by model weight: {said}."] if shares else []


def _detectable(record: DiagnosisRecord) -> str:
    if record.verdict not in ("adequate", "not observable"):
        return ""
    lines = []
    for name, parts in record.min_detectable.items():
        for part in parts:
            size = "–" if part.size is None else f"{number(part.size, 3)} {part.unit}"
            remark = (
                "" if part.observable else f"beyond what is physical or stable ({number(part.largest, 3)} {part.unit})"
            )
            lines.append([name, part.location, part.parameter, size, remark])
    head = "What would have been found in nine of ten cases, had it been there:"
    return f"{head}\n{aligned(['effect', 'location', 'unknown', 'from', ''], lines)}"


def _left_out(record: DiagnosisRecord) -> str:
    return "\n".join(f"Effect {name} was left out: {why}" for name, why in record.left_out.items())
