"""A diagnosis in sentences, tables and figures, of a record alone."""

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import ksmea
from ksmea.errors import SettingError
from ksmea.extended_model import extended_yaml
from ksmea.records.diagnosis import DiagnosisRecord, SplitRecord
from ksmea.records.extension import AveragedRecord, BandRecord, ExplanationRecord
from ksmea.show.charts import interactive, picture
from ksmea.show.charts.chart import Band, Bars
from ksmea.show.charts.ranking_chart import AS_WELL, NAMED, OTHER, best_trials, ranking_chart
from ksmea.show.diagnosis_findings import meaning, title, verdict_line
from ksmea.show.diagnosis_text import about_extension, coefficients_frame, diagnosis_chart, frame, plot, text

OLDER = json.loads((Path(__file__).parents[1] / "data/diagnosis_of_schema_2.json").read_text())
RECORD = DiagnosisRecord.from_data(OLDER)


def changed(**fields):
    return dataclasses.replace(RECORD, **fields)


def gain(**fields):
    return changed(predictive_gain=dataclasses.replace(RECORD.predictive_gain, **fields))


def test_the_text_names_the_cause_and_its_evidence():
    said = text(RECORD)
    location = RECORD.applied[0].location
    assert re.search(
        r"\n\nData: .*\d+ speeds from \d+ to \d+ rpm, \d channels \(x at .+\), amplitudes \(0-peak\) and phases\.\n\n",
        said,
    )
    assert "\n\nThe model does not fit: its residuals are not noise (p = 0.00075). They are largest at " in said
    assert f"Verdict: named – runout ({location})" in said
    assert "effect     location" in said and "ΔBIC" in said
    assert "What would have been found in nine of ten cases" not in said


def test_the_text_says_whether_left_out_data_support_the_extension():
    assert (
        "The extension is supported by left-out data: it predicts 6 of 6 blocks of speeds better (sign test p = 0.016,"
        " signed-rank p = 0.016)." in text(RECORD)
    )
    found = text(gain(is_supported=False, n_better=3, p_sign=42 / 64, p_wilcoxon=14 / 64, median=-1.0))
    assert "is not supported by left-out data: it predicts 3 of 6 blocks" in found and "-1 in the median block" in found


def test_a_name_that_left_out_data_do_not_confirm_says_what_both_mean_and_what_to_do():
    """The verdict stays, since it is of all the data; line, paragraph and headline of the page say the same."""
    doubtful = gain(is_supported=False)
    [applied] = RECORD.applied
    line = f"Verdict: named – runout ({applied.location}); left-out data do not confirm it"
    said = text(doubtful)
    assert f"{line}\n" in said and "left out do not confirm it" in meaning(doubtful)
    assert f"fitted to all of them, the model needs runout ({applied.location})." in said
    assert "Measure a further run and diagnose all together (measurement=campaign)" in said
    assert "not confirm" not in text(RECORD) and "further run" not in text(RECORD)
    unknown = dataclasses.replace(doubtful, verdict="unknown")  # believes no effect: there is nothing to confirm
    assert "confirm" not in text(unknown) and "further run" not in text(unknown)
    both = dataclasses.replace(ambiguous(), predictive_gain=doubtful.predictive_gain)
    assert "left out do not confirm it" in meaning(both)


def test_what_was_hidden_stands_below_all_that_was_found_and_apart_from_it():
    """With its location and its true values in their units, in a paragraph of its own; none where nothing was hidden."""
    found, _, hidden = text(RECORD).rpartition("\n\n")
    first, second = RECORD.hidden[0].parameters
    assert hidden == (
        "Hidden in these synthetic data (not seen by the diagnosis):\n"
        f"  runout ({RECORD.hidden[0].location}): runout_x = {first.value:.4g} µm, runout_y = {second.value:.4g} µm"
    )
    assert found == text(changed(hidden=())) and "idden" not in found


def test_effects_that_were_left_out_are_named_with_the_reason():
    assert "was left out" not in text(RECORD)
    record = changed(left_out={"mine": "does not fit this problem: KeyError: 3"}, hidden=())
    assert text(record).endswith("Effect mine was left out: does not fit this problem: KeyError: 3")
    assert DiagnosisRecord.from_data(record.to_data()).left_out == record.left_out and RECORD.left_out == {}


def test_verdicts_without_a_cause():
    after = dataclasses.replace(RECORD.lack_of_fit, after=None)
    nothing = {"named": (), "ambiguity_group": (), "applied": (), "predictive_gain": None, "lack_of_fit": after}
    unlikely = tuple(dataclasses.replace(trial, p=0.5) for trial in RECORD.ranking)
    insignificant = changed(verdict="unknown", ranking=unlikely, **nothing)
    assert "The model is wrong, and no known effect is significant." in text(insignificant)
    assert "an unknown cause explains the data as well as the known effects" in text(
        changed(verdict="unknown", **nothing)
    )
    adequate = text(changed(verdict="adequate", **nothing))
    assert "What would have been found in nine of ten cases" in adequate and "left-out" not in adequate
    assert "The nearest is runout" in text(changed(verdict="unknown"))


def test_a_verdict_without_an_explanation_prints_no_interval_of_a_model_that_is_rejected():
    """Neither of the model as given nor of the nearest effect, whose values and predictive gain are left out."""
    named, unknown = text(RECORD), text(changed(verdict="unknown"))
    [unit] = {row.before.unit for row in RECORD.coefficients if row.name == "kxx"}
    [kxx] = [line for line in unknown.splitlines() if line.split()[:1] == ["kxx"]]
    assert "[" in named and "[" not in unknown and kxx.endswith(unit) and len(kxx.split()) == 3
    assert "Values of the model as given, which is rejected; no interval holds for them:" in unknown
    assert "left-out data" not in unknown and "after" not in unknown.replace("left over", "")


def test_misread_data_say_how_and_show_the_values_of_data_read_so():
    read = "the data look as if speeds are in Hz where rpm are expected (× 60): read so, the fit leaves 5 % noise; multiply speed_rpm by that"
    record = changed(verdict="misread", reading=read, named=(), ambiguity_group=(), applied=(), predictive_gain=None)
    said = text(record)
    assert said.startswith("The data look as if speeds are in Hz where rpm are expected (× 60).")
    assert "multiply speed_rpm by that. Read so, the residuals are consistent with noise" in said
    assert (
        verdict_line(record) == "Verdict: misread – the data look as if speeds are in Hz where rpm are expected (× 60)"
    )
    assert any(line.split()[:1] == ["kxx"] and "[" in line for line in said.splitlines())


@pytest.mark.parametrize(
    ("n_channel", "said"),
    [(3, "+experiment=locate tells at which places"), (2, "Amplitudes and phases of 3 channels or more would tell")],
)
def test_of_an_unknown_cause_it_is_said_what_would_tell_the_place(n_channel, said):
    names = tuple(f"x at {position} m" for position in range(n_channel))
    curves = dataclasses.replace(RECORD.curves, channels=names)
    assert said in text(changed(verdict="unknown", curves=curves))
    real = dataclasses.replace(curves.responses, measured=((1.0,) * n_channel,))
    amplitudes = dataclasses.replace(curves, responses=real)
    assert "would tell at which places" in text(changed(verdict="unknown", curves=amplitudes))


def test_an_ambiguous_diagnosis_says_what_would_split_it():
    ambiguous = {"verdict": "ambiguous", "ambiguity_group": ("runout", "mass")}
    assert "These explain the data about as well: runout, mass." in text(changed(**ambiguous))
    assert "None of the measurements that were considered would tell them apart." in text(changed(**ambiguous))
    assert "The location is not certain: here or there." in text(changed(**ambiguous, locations=("here", "there")))


def written(record, folder):
    """The extended model's file as it is written, and as it is read again."""
    text = extended_yaml("three_disk", {"sensors": [0.1, 0.5]}, record, about_extension(record))
    (folder / "extended.yaml").write_text(text, encoding="utf-8")
    return text.splitlines(), ksmea.load_problem(folder / "extended.yaml")


def test_an_ambiguous_extended_model_says_first_that_it_is_one_of_several(tmp_path):
    ambiguous = changed(verdict="ambiguous", ambiguity_group=("runout", "mass"), source="run\nup.csv")
    [size] = [row.after for row in RECORD.coefficients if row.name == "runout_x"]
    split = SplitRecord("A trial weight", now=2.0, then=90.0)
    lines, problem = written(dataclasses.replace(ambiguous, split=split), tmp_path)
    assert lines[:5] == [
        "# One of several models: the diagnosis is ambiguous.",
        "# These explain the data about as well: runout, mass.",
        "# A trial weight would tell them apart (expected Δχ² at least 90, now 2).",
        f'# This file holds runout ({RECORD.applied[0].location}), fitted to the measurement "run\\nup.csv":',
        f"#   runout_x = {size.value:.2f} [{size.low:.2f}, {size.high:.2f}] µm",  # ± 0.23: two digits of it
    ]
    assert problem.reference["runout_x"] == pytest.approx(size.value)
    lines, _ = written(ambiguous, tmp_path)
    assert lines[2] == "# None of the measurements that were considered would tell them apart."


def test_a_named_extended_model_says_of_which_data_and_effect_it_is(tmp_path):
    lines, problem = written(RECORD, tmp_path)  # an older record, which does not say what was measured
    assert lines[0] == f"# This file holds runout ({RECORD.applied[0].location}), fitted to a measurement:"
    assert [line.split(" = ")[0] for line in lines[1:3]] == ["#   runout_x", "#   runout_y"]
    assert lines[3] == "problem:" and "runout_y" in problem.parameters.names
    lines, _ = written(changed(locations=("here", "there"), source="run.csv"), tmp_path)
    assert lines[0].endswith('fitted to the measurement "run.csv":')
    assert lines[3] == "# The location is not certain: here or there."


def test_a_size_on_its_physical_limit_is_pointed_out():
    first = RECORD.ranking[0]
    parts = tuple(dataclasses.replace(part, at_limit=True) for part in first.parameters)
    said = text(changed(ranking=(dataclasses.replace(first, parameters=parts), *RECORD.ranking[1:])))
    assert "  runout_x lies on its physical limit: a part that acts much like it is possible, too" in said


def test_the_frame_has_a_row_per_unknown_of_each_trial():
    table = frame(RECORD)
    assert len(table) == sum(len(trial.parameters) for trial in RECORD.ranking)
    first = table.iloc[0]
    part = RECORD.ranking[0].parameters[0]
    assert (first["rank"], first["effect"], first["location"]) == (1, "runout", RECORD.ranking[0].location)
    assert (first["delta_bic"], first["p"]) == (RECORD.ranking[0].delta_bic, RECORD.ranking[0].p)
    assert (first["unknown"], first["size"], first["unit"]) == (part.name, part.value, "µm")
    assert (first["low"], first["high"], first["interval"]) == (part.low, part.high, part.interval)
    assert table["delta_bic"].is_monotonic_decreasing and table["low"].dtype == float


def test_the_coefficients_frame_compares_both_models():
    table = coefficients_frame(RECORD).set_index("unknown")
    assert table.index.tolist() == [row.name for row in RECORD.coefficients]
    assert table.loc["kxx", "after"] == RECORD.coefficients[0].after.value and table.loc["kxx", "unit"] == "MN/m"
    assert pd.isna(table.loc["runout_x", "before"]) and table.loc["runout_x", "after_low"] < 4.46


def bars_of(record):
    """Place, ΔBIC and rank of each bar, the best effect first."""
    bars = [each for each in ranking_chart(record).panels[0].elements if isinstance(each, Bars)]
    return sorted((at, size, each.name) for each in bars for at, size in zip(each.at, each.size))


def ranks(record):
    """Rank of each bar by its colour, the best effect first."""
    names = [name.split(" ")[0] for name in ranking_chart(record).panels[0].y.ticks.values()]
    return {name: rank for name, (_, _, rank) in zip(names, bars_of(record), strict=True)}


def test_only_what_is_named_or_in_its_ambiguity_group_is_coloured():
    """Both effects are significant here: with a misfit as large as this nearly all are."""
    assert all(trial.p < 1e-9 for trial in RECORD.ranking)
    assert ranks(RECORD) == {"runout": NAMED, "mass": OTHER}
    group = changed(verdict="ambiguous", ambiguity_group=("runout", "mass"))
    assert ranks(group) == {"runout": NAMED, "mass": AS_WELL}
    unknown = changed(verdict="unknown", named=(), ambiguity_group=())
    assert set(ranks(unknown).values()) == {OTHER}


def test_the_page_and_the_figure_draw_the_same_bars():
    """ΔBIC on the same axis: linear up to 10, beyond a factor of 10 is as long as the linear part is in units of it."""
    assert [size for _, size, _ in bars_of(RECORD)] == [trial.delta_bic for trial in best_trials(RECORD)]
    chart = ranking_chart(RECORD)
    axes = picture.figure(chart).axes[0]
    place = axes.xaxis.get_transform().transform
    drawn = {bar.get_y() + bar.get_height() / 2: place(bar.get_width()) for bar in axes.patches}
    page = {at: x for trace in interactive.plot(chart)["data"] for at, x in zip(trace["y"], trace["x"])}
    assert page == pytest.approx(drawn, rel=1e-12)
    ends = place([0.0, 10.0, 100.0, 1000.0])
    assert ends[2:] - ends[1:-1] == pytest.approx(10.0)


def test_plot_draws_residuals_or_the_ranking_on_given_axes():
    residuals = plot(RECORD)
    n_channel = len(RECORD.curves.channels)
    assert len(residuals.axes) == 4 * n_channel  # phase, amplitude, residuals before and after
    [measured] = [each.get_ydata() for each in residuals.axes[n_channel].lines if each.get_label() == "measured"]
    assert len(measured) == len(RECORD.curves.speed) and np.all(measured > 0)
    figure = Figure()
    axes = figure.subplots()
    assert plot(RECORD, axes) is figure and len(axes.patches) == len(bars_of(RECORD)) == 2


def test_residuals_need_curves():
    with pytest.raises(SettingError, match="expected a record with its curves, got one without"):
        plot(changed(curves=None))


def ambiguous():
    """The record as if a mass explained the data as well, with averaged values and a band."""
    amplitude = np.abs(np.array(RECORD.curves.responses.after) @ [1, 1j])
    band = BandRecord(*(tuple(map(tuple, part.tolist())) for part in (amplitude, 0 * amplitude, 2 * amplitude)))
    runout = RECORD.applied[0]
    mass = dataclasses.replace(runout, name="mass", location="whole rotor")
    rows = [row.after for row in RECORD.coefficients if row.before is not None]
    wider = tuple(dataclasses.replace(row, low=None, high=2 * row.value, interval="mixture") for row in rows)
    return changed(
        verdict="ambiguous",
        ambiguity_group=("runout", "mass"),
        explanations=(
            ExplanationRecord("runout", (runout,), 100.0, 90.0, 0.7),
            ExplanationRecord("mass", (mass,), 98.0, 92.0, 0.3),
        ),
        averaged=AveragedRecord(0.95, wider),
        curves=dataclasses.replace(RECORD.curves, averaged=band),
    )


def test_an_older_record_has_no_average():
    assert RECORD.explanations == () and RECORD.averaged is None and RECORD.curves.averaged is None
    assert "Averaged" not in text(RECORD) and "averaged" not in coefficients_frame(RECORD)


def test_averaged_values_stand_beside_those_of_the_best_explanation():
    record = ambiguous()
    said = text(record)
    assert "Averaged over all that explain the data about as well, by model weight: runout 0.70, mass 0.30." in said
    assert re.search(r"unknown +as given +with the cause +averaged +unit", said)
    table = coefficients_frame(record).set_index("unknown")
    assert table.loc["kxx", "averaged"] == table.loc["kxx", "after"] and pd.isna(table.loc["kxx", "averaged_low"])
    assert table.loc["kxx", "averaged_high"] == 2 * table.loc["kxx", "after"] and pd.isna(
        table.loc["runout_x", "averaged"]
    )
    assert DiagnosisRecord.from_data(json.loads(json.dumps(record.to_data()))) == record


def test_the_text_lists_what_is_named_and_what_explains_as_well_however_low_it_ranks():
    first = RECORD.ranking[0]
    others = [dataclasses.replace(first, effect=f"other_{number}") for number in range(7)]
    second, alike, last = (dataclasses.replace(first, effect=name) for name in ("second", "alike", "unasked"))
    elsewhere = dataclasses.replace(second, location="at 0.9 m")
    effects = (*RECORD.applied, dataclasses.replace(RECORD.applied[0], name="second", location="at 0.9 m"))
    record = changed(
        ranking=(first, *others, second, elsewhere, alike, last),
        named=("runout", "second"),
        ambiguity_group=("runout", "second", "alike"),
        applied=effects,
    )
    rows = [line.split()[0] for line in text(record).splitlines() if re.search(r" at 0\.\d m  +[\d.]+ ", line)]
    assert rows == ["runout", *(f"other_{number}" for number in range(5)), "second", "second", "alike"]


def test_an_estimated_noise_says_of_which_model_it_is():
    noise = dataclasses.replace(RECORD.noise, known=False, by_datum=False)
    [applied] = RECORD.applied
    assert f"\nNoise (estimated with runout ({applied.location})): " in text(changed(noise=noise))
    plain = {"verdict": "adequate", "named": (), "applied": (), "predictive_gain": None}
    assert "\nNoise (estimated): " in text(changed(noise=noise, **plain))
    known = dataclasses.replace(noise, known=True)
    assert "\nNoise (known): " in text(changed(noise=known))


def test_pairs_that_are_ambiguous_are_listed_as_pairs():
    [runout, mass] = ambiguous().explanations
    both = dataclasses.replace(runout, label="runout and mass", effects=runout.effects + mass.effects)
    other = dataclasses.replace(both, label="runout and youngs_modulus")
    found = text(changed(verdict="ambiguous", explanations=(both, other)))
    assert "These explain the data about as well: runout and mass, runout and youngs_modulus." in found


def test_a_title_lists_pairs_as_pairs():
    """Also where both effects of a pair have one name."""
    [runout, mass] = ambiguous().explanations
    twice = dataclasses.replace(runout, label="runout at 0.1 m and runout at 0.5 m", effects=2 * runout.effects)
    other = dataclasses.replace(runout, label="runout and mass", effects=runout.effects + mass.effects)
    found = changed(verdict="ambiguous", named=("runout",), applied=twice.effects, explanations=(twice, other))
    assert title(found).startswith("Runout at 0.1 m with runout at 0.1 m or runout at 0.1 m with mass: these data")


def test_effects_beside_an_adequate_model_are_called_what_they_are():
    said = text(changed(verdict="adequate", named=(), applied=(), predictive_gain=None))
    assert "Verdict: adequate\n\nThe model explains the data. The effects that come nearest to being needed:\n" in said
    assert "come nearest" not in text(RECORD)


def test_the_band_of_the_average_is_drawn_to_a_positive_end():
    [band] = [each for each in diagnosis_chart(ambiguous()).panels[1].elements if isinstance(each, Band)]
    assert band.name == "averaged, its interval"
    assert np.nanmin(band.low) > 0  # of a logarithmic axis
