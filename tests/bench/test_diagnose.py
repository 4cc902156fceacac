"""`+experiment=diagnose` as its users meet it: sentences, diagnosis.json, extended.yaml, figures; many runs counted."""

import csv
import dataclasses
import json
import os
import shutil
from pathlib import Path

import pandas as pd
import pytest

from bench.plan.plan import ParameterFacts, read_plan
from bench.reports.diagnosis.report import coefficients, found_name, times_in_one
from ksmea.records.diagnosis import CoefficientRecord, DiagnosisRecord
from ksmea.records.estimate import EstimateRecord
from ksmea.records.extension import AveragedRecord, EffectRecord, ExplanationRecord
from ksmea.records.hidden import HiddenEffect
from measurements.file import File
from measurements.run_up_csv import as_csv

ROOT = Path(__file__).parents[2]
RK4_RUN_UP = Path(os.environ.get("KSMEA_DATA", ROOT.parent / "shared/data")) / "rk4/runup_bode_first_critical.csv"
FEW = "study.effects=[runout,mass,channel_gain]"  # a few effects take a second, all of them ten
NOT_LOCATED = "study.locate=false"  # which takes five seconds more; tests/bench/test_locate.py is about it
DATA = [
    "measurement.kind=complex",
    "measurement.relative=0.05",
    "measurement.floor=0.05",
    "measurement.noise_known=false",
    "measurement.mesh=26",
    "measurement.route=dense",
    "problem.sensors=[0.1,0.5]",
]
HIDDEN = "measurement.hidden=[runout]"


@pytest.fixture(scope="module")
def hidden(apart, tmp_path_factory):
    """A diagnosis of data that hide a runout."""
    words = ["+experiment=diagnose", *DATA, HIDDEN, FEW, NOT_LOCATED, "seed=3"]
    return apart(*words, draws=True, cwd=tmp_path_factory.mktemp("hidden"), output="results/diagnose")


def diagnosis(ended):
    return json.loads((ended.output / "diagnosis.json").read_text())


def test_it_says_what_is_wrong_and_names_the_cause(hidden):
    assert hidden.code == 0, hidden.err
    assert "The model does not fit: its residuals are not noise" in hidden.out
    assert "Verdict: named – runout" in hidden.out
    assert "The extension is supported by left-out data: it predicts 6 of 6 blocks of speeds better" in hidden.out
    assert "Its elpd difference is +" in hidden.out
    assert "written: diagnosis.json, extended.yaml" in hidden.out


def test_diagnosis_json_has_all_that_is_promised(hidden):
    found = diagnosis(hidden)
    assert found["verdict"] == "named" and found["named"] == ["runout"] and found["ambiguity_group"] == ["runout"]
    assert found["lack_of_fit"]["before"]["p"] < 0.005 < found["lack_of_fit"]["after"]["p"]
    gain = found["predictive_gain"]
    assert gain["elpd_difference"] > 2 * gain["standard_error"] > 0 and gain["is_supported"]
    assert gain["rmse_after"] < gain["rmse_before"]
    assert set(found["min_detectable"]) == {"runout", "mass", "channel_gain"}
    best = found["ranking"][0]
    assert best["effect"] == "runout" and best["p"] < 1e-6 and best["delta_bic"] > 50
    for parameter in best["parameters"]:
        assert parameter["low"] < parameter["value"] < parameter["high"] and parameter["unit"] == "µm"
    bic = [trial["delta_bic"] for trial in found["ranking"]]
    assert bic == sorted(bic, reverse=True) and len(bic) == 2 + 1 + 4  # planes, rotor, channels


def test_what_is_hidden_is_told_apart_from_what_was_found(hidden):
    """Below the text, in a field of its own at the end of diagnosis.json, and in a column of both tables."""
    (record,) = hidden.events()
    (effect,) = record["hidden"]
    found = diagnosis(hidden)
    assert effect["effect"] == "runout" and effect["location"] == found["applied"][0]["location"]
    assert list(found)[-1] == "hidden" and found["hidden"] == record["hidden"]
    told = str(HiddenEffect.from_data(effect))
    below = hidden.out.partition("Hidden in these synthetic data (not seen by the diagnosis):\n")[2]
    assert below.startswith(f"  {told}\n\nwritten: ") and told not in hidden.out.partition("Hidden in")[0]
    for name in ("diagnose.csv", "runs.csv"):
        assert pd.read_csv(hidden.output / name)["hidden_values"].tolist() == [told]


def test_how_clearly_visible_it_was_is_judged_from_the_true_values(hidden):
    (record,) = hidden.events()
    (effect,) = record["hidden"]
    # by a fit that the diagnosis knows nothing of
    assert record["hidden_deviance_drop"] == pytest.approx(record["ranking"][0]["deviance_drop"], abs=0.01)
    found = {part["name"]: part for part in diagnosis(hidden)["ranking"][0]["parameters"]}
    for part in effect["parameters"]:  # 95 % intervals, taken twice as wide
        interval = found[part["name"]]
        assert abs(part["value"] - interval["value"]) < interval["high"] - interval["low"]


@pytest.mark.slow
def test_the_extended_model_is_a_problem_that_other_commands_take(hidden, enter):
    head = (hidden.output / "extended.yaml").read_text(encoding="utf-8").splitlines()[0]
    assert head.startswith("# This file holds runout (") and head.endswith('fitted to the measurement "synthetic":')
    words = ["problem=extended", f"problem.file={hidden.output / 'extended.yaml'}", "measurement.relative=0.05"]
    cheap = ["method=direct", "optimizer=lm", "repetitions=1", "optimizer.screening=500", "optimizer.starts=2"]
    ended = enter(*words, *cheap, "workers=1")
    assert ended.code == 0, ended.err
    table = pd.read_csv(ended.output / "run.csv").set_index("parameter")
    identified = {row["name"]: row["after"] for row in diagnosis(hidden)["coefficients"]}
    for name in ("kxx", "runout_x"):  # what was identified is the reference of the extended problem
        assert table.loc[name, "reference"] == pytest.approx(identified[name]["value"], rel=1e-6)


@pytest.mark.slow
def test_a_reversed_probe_of_a_file_is_noticed_and_data_that_were_made_are_not_looked_at(enter, hidden, tmp_path):
    measurement = File(path=str(ROOT / "docs/examples/run_up.csv")).read()
    turned = dataclasses.replace(measurement, values=measurement.values * [1, -1])
    (tmp_path / "run.csv").write_text(as_csv(turned))
    words = ["measurement=file", "measurement.path=run.csv", "study.effects=[channel_gain]"]
    ended = enter("+experiment=diagnose", *words, output="results/diagnose_run")
    assert ended.code == 0, ended.err
    assert diagnosis(ended)["verdict"] == "misread"
    assert "the phases of x at 0.1 m or else of y at 0.1 m are turned by 180°" in diagnosis(ended)["reading"]
    assert ended.out.startswith("The data look as if the phases of x at 0.1 m or else of y at 0.1 m are turned by 180°")
    assert diagnosis(hidden)["remarks"] == [] and diagnosis(hidden)["verdict"] != "misread"


def test_figures_are_drawn(hidden):
    for name in ("residuals.png", "effects.png"):
        assert (hidden.output / name).read_bytes().startswith(b"\x89PNG")


def test_an_adequate_model_leaves_no_extended_file_behind(hidden, enter, tmp_path):
    once = shutil.copytree(hidden.output, tmp_path / "results/diagnose")
    assert (once / "extended.yaml").is_file()
    again = enter("+experiment=diagnose", *DATA, FEW, NOT_LOCATED, "seed=3", output="results/diagnose")
    assert "Verdict: adequate" in again.out and "What would have been found in nine of ten cases" in again.out
    assert not (again.output / "extended.yaml").exists() and diagnosis(again)["named"] == []
    said, _, earlier = again.out.partition("note: 1 earlier result")  # whose command is told: it hid something
    assert "idden" not in said and "hidden" not in diagnosis(again) and "measurement.hidden=[runout]" in earlier


@pytest.mark.parametrize(
    ("verdict", "averaged", "expected"),
    [
        ("adequate", None, (1, 0)),
        ("named", None, (1, 1)),
        ("ambiguous", None, (0, 0)),
        ("ambiguous", (4.0, 6.0), (1, 1)),
        ("unknown", None, (0, 0)),
    ],
)
def test_intervals_that_are_reported_are_set_beside_true_values(hidden, verdict, averaged, expected):
    """The true 5 kN/mm is outside of what the model as given says, inside what the extended one says; an effect has no true value
    in the cell, and so is not counted."""
    [line] = hidden.events()
    made = DiagnosisRecord.from_data(line)
    before, after = (
        EstimateRecord("k", "kN/mm", *values, "profile", False) for values in ((7.0, 6.5, 7.5), (5.2, 4.9, 5.5))
    )
    effect = CoefficientRecord("runout", None, dataclasses.replace(after, name="runout"))
    average = averaged and AveragedRecord(0.95, (EstimateRecord("k", "kN/mm", 5.0, *averaged, "mixture", False),))
    record = dataclasses.replace(
        made, verdict=verdict, coefficients=(CoefficientRecord("k", before, after), effect), averaged=average
    )
    [cell] = read_plan(hidden.output).cells
    facts = (ParameterFacts("k", "kN/mm", 1e6, 5e6),)
    row = coefficients(record, dataclasses.replace(cell, parameters=facts))
    assert tuple(row.values()) == expected


@pytest.mark.slow
def test_many_runs_are_counted(enter):
    words = ["+experiment=diagnosis_effects", *DATA, FEW, "repetitions=2", "workers=1", "seed=3"]
    grid = "grid=[{label:runout,measurement.hidden:[[runout]]},{label:none,measurement.hidden:[[]]}]"
    ended = enter(*words, grid, output="results/diagnosis_effects")
    assert ended.code == 0, ended.err
    table = pd.read_csv(ended.output / "diagnosis_effects.csv").set_index("label")
    assert table.loc["runout", ["clearly_visible", "in_group", "is_first"]].tolist() == [2, 2, 2]
    assert table.loc["runout", ["fit_short", "surplus"]].tolist() == [0, 0]
    assert table.loc["none", "adequate"] == 2 and pd.isna(table.loc["none", "in_group"])
    runs = pd.read_csv(ended.output / "runs.csv")
    assert runs.loc[runs["label"] == "runout", "sizes_compared"].tolist() == [2, 2]
    assert runs["coefficients_compared"].tolist() == [6] * 4  # kxx to u and the phase origin, named or adequate
    assert table.loc["runout", "coefficients"] == 12 >= table.loc["runout", "coefficients_held"] > 0
    assert runs["hidden_values"].notna().tolist() == [label == "runout" for label in runs["label"]]
    assert runs["hidden_values"].nunique() == 2  # each run draws its own
    assert "  drawn by each run: hidden_values in runs.csv\n" in ended.out
    assert not (ended.output / "diagnosis.json").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["measurement.kind=complex"], "expected noise, without which any difference is a misfit"),
        (["measurement.relative=0.1", "study.effects=[runuot]"], "did you mean 'runout'?"),
        (["measurement.relative=0.1", "measurement.hidden=[mas]"], "did you mean 'mass'?"),
        (["measurement.relative=0.1", "study.effects=[local_force]"], "got local_force; give its position"),
        (["measurement.relative=0.1", "measurement.hidden=[local_force]"], "got local_force; give its position"),
        (["measurement.relative=0.1", "problem.n_speed=3"], "expected at least 10 data, twice the unknowns, got 6"),
        (["measurement=file", "measurement.path=nothing.csv"], "nothing.csv: expected a CSV file, found none"),
    ],
)
def test_bad_input_is_one_line(enter, words, said):
    ended = enter("+experiment=diagnose", *words, output="results/diagnose")
    assert ended.code == 2 and said in ended.err and ended.err.count("\n") == 1
    assert not ended.output.exists()


@pytest.mark.skipif(not RK4_RUN_UP.is_file(), reason=f"{RK4_RUN_UP} is not here: public data that are not committed")
@pytest.mark.slow
def test_a_real_sweep_through_a_critical_speed_is_no_steady_response(enter, tmp_path):
    """It beats behind the critical, which no effect on a steady rotor explains: without a sweep the answer is 'unknown'."""
    with RK4_RUN_UP.open() as file:
        rows = [[row["rpm"], "0.12", "x", row["amp_1x_um_0pk"], row["phase_1x_deg"]] for row in csv.DictReader(file)]
    header = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg"
    (tmp_path / "rk4.csv").write_text("\n".join([header, *map(",".join, rows)]))
    few = "study.effects=[runout,cross_coupling_symmetric,speed_dependent_damping]"
    words = ["problem=rk4_two_disk", "measurement=file", "measurement.path=rk4.csv", few]
    ended = enter("+experiment=diagnose", *words, output="results/diagnose_rk4")
    assert ended.code == 0, ended.err
    assert diagnosis(ended)["verdict"] == "unknown" and diagnosis(ended)["named"] == []


@pytest.mark.parametrize(
    ("hidden", "location", "names", "expected"),
    [
        ("runout_x", "at 0.1 m", ["runout_x"], "runout_x"),
        ("runout_x_at_0_5_m", "at 0.5 m", ["runout_x", "runout_x_at_0_5_m"], "runout_x_at_0_5_m"),
        # the one at 0.5 m was found first, and has the plain names
        ("runout_x", "at 0.1 m", ["runout_x", "runout_x_at_0_1_m"], "runout_x_at_0_1_m"),
        ("runout_x_at_0_5_m", "at 0.5 m", ["runout_x", "runout_x_at_0_1_m"], "runout_x"),
    ],
)
def test_what_is_hidden_at_two_places_is_compared_with_what_was_found_there(hidden, location, names, expected):
    assert found_name(hidden, location, names) == expected


def test_one_of_two_that_are_hidden_at_two_places_is_not_both():
    def explanation(*positions):
        effects = tuple(EffectRecord("runout", f"at {each} m", {"position": each}) for each in positions)
        return ExplanationRecord("runout", effects, deviance_drop=100.0, delta_bic=90.0)

    assert times_in_one([explanation(0.1), explanation(0.5)], "runout") == 1
    assert times_in_one([explanation(0.1), explanation(0.1, 0.5)], "runout") == 2
    assert times_in_one([explanation(0.1, 0.5)], "mass") == 0
