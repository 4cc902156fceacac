"""Records of diagnoses go to JSON and come back; those of earlier versions are read as the present ones."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.problem.case import Case
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.studies.diagnose import DiagnosisOptions, diagnosis
from tests.diagnosis.conftest import registered_effects

FAST = DiagnosisOptions(screening=1024, scan=64, scan_values=8, effect_starts=3, locate=False)
OLDER = json.loads((Path(__file__).parents[1] / "data/diagnosis_of_schema_2.json").read_text())


@pytest.fixture(scope="module")
def record(rotor, hide):
    measurement, _, _ = hide("runout", 1)
    effects = {name: effect for name, effect in registered_effects().items() if name in ("runout", "channel_gain")}
    return diagnosis(Case(rotor, measurement), effects, np.random.default_rng(0), options=FAST)


@pytest.mark.slow
def test_a_record_comes_back_from_json(record):
    assert record.verdict == "named" and record.named == record.ambiguity_group == ("runout",)
    assert DiagnosisRecord.from_data(json.loads(json.dumps(record.to_data()))) == record


def test_what_stands_in_json_is_the_record(record):
    data = record.to_data()
    assert {"verdict", "named", "ambiguity_group", "locations", "predictive_gain", "collinearity"} <= data.keys()
    assert data["ranking"][0].keys() == {"effect", "location", "deviance_drop", "delta_bic", "p", "parameters", "words"}
    assert not data["hidden"] and data["hidden_deviance_drop"] is None  # nothing that a diagnosis could know


def test_the_deviance_drop_is_that_of_the_two_fits(record):
    before, after = record.lack_of_fit.before, record.lack_of_fit.after
    drop = record.ranking[0].deviance_drop
    assert before.deviance - after.deviance == pytest.approx(drop, abs=0.01)
    assert before.p < record.lack_of_fit.level < after.p


def test_an_older_record_is_read_with_the_present_names():
    found = DiagnosisRecord.from_data(OLDER)
    assert found.verdict == "named" and found.ambiguity_group == tuple(OLDER["class"])
    assert found.locations == tuple(OLDER["places"]) and found.effects == tuple(OLDER["tried"])
    assert found.collinearity == OLDER["likeness"]
    for trial, was in zip(found.ranking, OLDER["ranking"]):
        assert (trial.location, trial.deviance_drop, trial.p) == (was["place"], was["fall"], was["p"])
        assert [part.at_limit for part in trial.parameters] == [part["at_bound"] for part in was["parameters"]]
    assert found.applied[0].location == OLDER["applied"][0]["place"]
    assert found.applied[0].settings == OLDER["applied"][0]["settings"]
    assert found.min_detectable["mass"][0].location == OLDER["min_detectable"]["mass"][0]["place"]
    before = found.lack_of_fit.before
    assert OLDER["lack_of_fit"]["before"]["statistic"] == "neighbours"
    assert before.statistic == "autocorrelation over speed" and before.deviance is None
    assert list(before.p_by_statistic) == [
        "autocorrelation over speed",
        "cross-channel correlation",
        "largest residual",
        "band and channel",
        "χ²",
    ]
    assert list(before.p_by_statistic.values()) == list(OLDER["lack_of_fit"]["before"]["p_by_statistic"].values())
    assert found.hidden[0].location == OLDER["hidden"][0]["place"]
    assert found.hidden_deviance_drop == OLDER["hidden_fall"]


def test_an_older_predictive_gain_is_judged_by_its_blocks():
    """Better in all blocks by very different amounts: within two standard errors, and supported."""
    was, found = OLDER["gain"], DiagnosisRecord.from_data(OLDER).predictive_gain
    assert not was["is_proven"] and all(block > 0 for block in was["by_block"])
    assert found.elpd_difference == pytest.approx(was["log_score"], rel=1e-12)
    assert found.standard_error == pytest.approx(was["standard_error"], rel=1e-12)
    assert found.is_supported and found.n_better == 6 and found.p_sign == pytest.approx(2**-6)


def test_a_record_once_read_stays_as_it_is():
    found = DiagnosisRecord.from_data(OLDER)
    assert DiagnosisRecord.from_data(found.to_data()) == found


def test_an_older_record_without_an_extension_is_read():
    tests = {**OLDER["lack_of_fit"], "after": None}
    found = DiagnosisRecord.from_data({**OLDER, "gain": None, "lack_of_fit": tests, "verdict": "adequate"})
    assert found.predictive_gain is None and found.lack_of_fit.after is None


def test_what_is_no_diagnosis_is_refused_in_one_line(record):
    data = dataclasses.replace(record, named=3).to_data()
    with pytest.raises(SettingError, match=r"DiagnosisRecord: expected its fields, could not read them: .*named"):
        DiagnosisRecord.from_data(data)
