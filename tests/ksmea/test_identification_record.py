"""The record of an identification: through JSON and back, from older files, and with the truth beside it."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.records.curves import ResponseCurves, as_array, matrix
from ksmea.records.identification import (
    FitCurves,
    IdentificationRecord,
    NoiseLevel,
    ParameterRecord,
    Seconds,
    UpdateRecord,
)

OLDER = Path(__file__).resolve().parents[1] / "data" / "identifications_schema_2.jsonl"


@pytest.fixture(scope="module")
def older():
    """The lines of two runs as schema 2 had them: synthetic data of known truth, and a measured file with details."""
    return [json.loads(line) for line in OLDER.read_text(encoding="utf-8").splitlines()]


def parameter(name="kxx", identified=49e6, **others):
    return ParameterRecord(name, "MN/m", 1e6, identified, False, **others)


def record_of(*parameters, **others):
    counts = {"updates": 0, "model_evaluations": 1, "model_jacobians": 0, "surrogate_evaluations": 0}
    return IdentificationRecord("done", "optimizer", parameters, 1.0, **counts, seconds=Seconds(), **others)


def test_a_record_of_schema_2_is_read_with_its_fields_by_their_present_names(older):
    line, _ = older
    record = IdentificationRecord.from_data(line)
    assert (record.status, record.stop, record.updates, record.surrogate_evaluations) == ("done", "smc", 6, 4417)
    for was, now in zip(line["parameters"], record.parameters, strict=True):
        names = {"at_bound": "at_limit", "interval": "kind", "likely": "most_likely"}
        assert {names.get(name, name): value for name, value in was.items()} == {
            name: value for name, value in dataclasses.asdict(now).items() if name not in ("crlb", "origin")
        }
        assert now.crlb is None and now.origin is None
    assert record.intervals.noise == NoiseLevel(0.1, 0.0, estimated=False)
    noise = {**line["interval"]["noise"], "by_run": ()}  # which came later
    assert dataclasses.asdict(record.intervals) == {**line["interval"], "noise": noise}
    assert record.interval_error is None and record.deviance is None
    assert record.history[1] == UpdateRecord(**{**line["history"][1], "x": tuple(line["history"][1]["x"])})
    assert dataclasses.asdict(record.seconds) == line["seconds"]
    assert isinstance(record.curves, ResponseCurves)
    for name in ("speed", "true", "measured", "identified", "predicted", "modelled"):
        assert as_array(getattr(record.curves, name)) == pytest.approx(np.array(line["curves"][name]), rel=0)


def test_a_record_of_schema_2_with_details_is_read_whole(older):
    _, line = older
    record = IdentificationRecord.from_data(line)
    assert [part.crlb for part in record.parameters] == [part["bound"] for part in line["parameters"]]
    assert record.data.source == "run_up.csv" and record.data.kind == "complex" and record.data.n_speed == 90
    assert record.lack_of_fit.p == line["lack_of_fit"]["p"] and not record.lack_of_fit.rejected
    assert as_array(record.correlation) == pytest.approx(np.array(line["correlation"]), rel=0)
    assert isinstance(record.fit, FitCurves) and record.fit.has_phase
    assert as_array(record.fit.fine.phase) == pytest.approx(np.array(line["fit"]["fine"]["phase"]), rel=0)


def test_why_there_are_no_intervals_is_read_from_schema_2(older):
    line = {**older[0], "interval": {"error": "Singular matrix"}}
    record = IdentificationRecord.from_data(line)
    assert record.intervals is None and record.interval_error == "Singular matrix"
    without = IdentificationRecord.from_data({name: value for name, value in line.items() if name != "interval"})
    assert without.intervals is None and without.interval_error is None


def test_a_record_goes_through_json_and_back(older):
    for line in older:
        record = IdentificationRecord.from_data(line)
        assert IdentificationRecord.from_data(json.loads(json.dumps(record.to_data()))) == record


def test_what_is_no_record_is_refused_in_one_line():
    with pytest.raises(SettingError, match="IdentificationRecord: expected its fields") as caught:
        IdentificationRecord.from_data({"status": "done"})
    assert "\n" not in str(caught.value)


def test_the_truth_comes_beside_what_was_identified():
    parameters = Parameters((Parameter("kxx", "MN/m", 1e6, 10e6, 100e6), Parameter("kyy", "MN/m", 1e6, 10e6, 100e6)))
    record = record_of(parameter(), parameter("kyy", 77e6), curves=ResponseCurves((1.0,), ("x at 0 m",)))
    response = np.array([[3e-6 - 4e-6j]])
    told = record.with_truth(parameters, {"kxx": 50e6}, response)
    assert [part.true for part in told.parameters] == [50e6, None]
    assert told.parameters[0].error_pct == pytest.approx(-2.0) and told.parameters[1].error_pct is None
    assert as_array(told.curves.true) == pytest.approx(np.array([[5e-6]]))
    assert record.parameters[0].true is None and record.curves.true is None  # it is another record
    assert record_of(parameter()).with_truth(Parameters(parameters.items[:1]), {}, response).curves is None


@pytest.mark.parametrize(
    ("low", "high", "true", "expected"),
    [
        (48e6, 50e6, 49e6, True),
        (48e6, 50e6, 50e6, True),
        (48e6, 50e6, 51e6, False),
        (None, 50e6, 1e6, True),
        (48e6, None, 1e6, False),
        (None, None, 1e9, True),
        (48e6, 50e6, None, None),
    ],
)
def test_an_open_side_holds_everything(low, high, true, expected):
    assert parameter(low=low, high=high, true=true).is_covered is expected


def test_values_in_their_unit():
    part = parameter()
    assert part.in_unit(part.identified) == 49.0 and np.isnan(part.in_unit(None))
    assert parameter(true=0.0).error_pct is None


def test_curves_keep_8_digits_and_no_number_that_is_not_finite():
    assert matrix(np.array([[1 / 3, np.nan], [np.inf, 2.0]])) == ((0.33333333, None), (None, 2.0))
    assert np.isnan(as_array(((1.0, None),))[0, 1])
