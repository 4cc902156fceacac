"""JSON says the unit of every number, beside it or in its name, and is read back as the record that it was made of."""

import dataclasses
import json
import re
import typing
from pathlib import Path
from types import SimpleNamespace

import pytest

import ksmea
from bench.reports.diagnosis.report import public
from ksmea.records import location, planning
from ksmea.records.balancing import BalanceRecord
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.estimate import NoiseLevelRecord
from ksmea.records.identifiability import IdentifiabilityRecord
from ksmea.records.identification import IdentificationRecord
from ksmea.records.location import LocationRecord
from ksmea.records.planning import PlanningRecord
from ksmea.records.record import Record
from ksmea.show.diagnosis_text import text
from ksmea.show.json_units import BESIDE_UNIT, IN_SI, units_of, with_units
from ksmea.show.text import noise_level
from ksmea.units import Speed

DATA = Path(__file__).parents[1] / "data"
DIAGNOSIS = DiagnosisRecord.from_data(json.loads((DATA / "diagnosis_of_schema_2.json").read_text()))
WRITTEN = (BalanceRecord, DiagnosisRecord, IdentifiabilityRecord, IdentificationRecord, LocationRecord, PlanningRecord)

# Numbers without a unit: chances, counts, parts, ratios, and what is in units of the noise.
PLAIN = re.compile(
    r"p|p_.*|n_.*|.*_p|.*_pct|seconds|level|.*_level|chi2|reduced_chi2|deviance.*|.*_deviance_drop|delta_bic|bic|excess|weight|.*_excess"
    r"|elpd_difference|standard_errors?|by_block|median|now|then|collinearity|breaks|whirl|coherence|degrees|ratio|dof"
    r"|misfit|predicted_misfit|polish_gain|updates|.*evaluations|.*jacobians|notes|error|least|correlation|sigmas|change"
    r"|candidate|slope|growth|spread_growth|coverage|smc"
)


def classes(record_type, seen):
    """Every dataclass that fields of a record lead to."""
    if dataclasses.is_dataclass(record_type) and record_type not in seen:
        seen[record_type] = typing.get_type_hints(record_type)
        for hint in seen[record_type].values():
            classes(hint, seen)
    for part in typing.get_args(record_type):
        classes(part, seen)
    return seen


def is_numeric(hint):
    return hint in (float, int) or any(map(is_numeric, typing.get_args(hint)))


REACHED = {record_type: hints for record in WRITTEN for record_type, hints in classes(record, {}).items()}


def test_every_number_of_every_record_has_its_unit():
    """In the type of its field, in a field `unit` of its record or of the one that holds it, or in its name."""
    of_parent = {"SeriesRecord", "PolarRecord"}  # sizes whose unit stands beside the field that holds them
    for record_type, hints in REACHED.items():
        if "unit" in hints or "units" in hints or record_type.__name__ in of_parent:
            continue
        for name, hint in hints.items():
            told = name in units_of(record_type) or PLAIN.fullmatch(name)
            assert told or not is_numeric(hint), f"{record_type.__name__}.{name} has no unit"


def test_what_is_told_in_its_unit_too_are_fields_that_there_are():
    in_si = {record_type: record_type.IN_UNIT for record_type in REACHED if hasattr(record_type, "IN_UNIT")}
    assert len(in_si) == 4
    for record_type, fields in in_si.items():
        assert all(hasattr(record_type, name) or name in REACHED[record_type] for name in fields), record_type


@pytest.mark.parametrize(
    ("record", "field", "unit"),
    [  # what the fields' own comments say
        (planning.Candidates, "crlb", "SI, of the target"),
        (planning.Candidates, "magnitude", "kg m"),
        (planning.PlanningRecord, "crlb", "SI"),
        (location.SiteRecord, "position", "m"),
        (location.StiffnessRecord, "real", "N/m"),
        (location.LocationRecord, "work", "J"),  # a property
        (NoiseLevelRecord, "relative", "1"),
        (NoiseLevelRecord, "floor", "m"),
    ],
)
def test_units_are_those_of_the_fields(record, field, unit):
    assert units_of(record)[field].unit == unit


@pytest.mark.parametrize(("times", "unit"), [((0, 1, 2), None), ((0.0, 60.0, 125.0), "s")])
def test_runs_without_a_time_are_counted_and_have_no_unit(times, unit):
    told = units_of(BalanceRecord)["run_time"](SimpleNamespace(run_time=times))
    assert (told and told.unit) == unit


def test_a_diagnosis_in_json_has_the_numbers_of_its_text():
    told = json.loads(json.dumps(public(DIAGNOSIS), allow_nan=False))
    assert next(iter(told.items())) == ("units", BESIDE_UNIT)
    size = next(each["after"] for each in told["coefficients"] if each["name"] == "runout_x")
    assert (f"{size['value']:.2f}", size["unit"]) == ("4.46", "µm") and "4.46" in text(DIAGNOSIS)
    noise = told["noise"]["after"]
    assert noise["floor_unit"] == "m" and noise["floor"] == DIAGNOSIS.noise.after.floor
    assert noise_level(DIAGNOSIS.noise.after) == f"{noise['relative_pct']:.3g} % of each value" + (
        f" and {noise['floor_um']:.3g} µm" if noise["floor"] else ""
    )
    fit = told["lack_of_fit"]["before"]
    assert fit["band_unit"] == "rad/s"
    assert fit["band_rpm"] == pytest.approx([speed * 30 / 3.141592653589793 for speed in fit["band"]])
    gain = told["predictive_gain"]
    assert gain["rmse_before_um"] == pytest.approx(1e6 * gain["rmse_before"]) and gain["rmse_before_unit"] == "m"


def test_a_floor_is_told_in_both_units():
    told = with_units(NoiseLevelRecord(0.05, 7e-8))
    assert told == {
        "units": BESIDE_UNIT,
        "relative": 0.05,
        "relative_unit": "1",
        "relative_pct": pytest.approx(5.0),
        "floor": 7e-8,
        "floor_unit": "m",
        "floor_um": pytest.approx(0.07),
        "by_run": (),
    }


@pytest.fixture(scope="module")
def rotor():
    return ksmea.load_problem("three_disk", n_speed=20)


@pytest.fixture(scope="module")
def found(rotor):
    data = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", rng=1)
    return ksmea.identify(rotor, data)


def test_an_identification_in_json_has_values_in_their_unit(found):
    told = json.loads(found.to_json())
    first, value = told["parameters"][0], found["kxx"]
    assert next(iter(told.items())) == ("units", IN_SI)
    assert (first["unit"], first["in_unit"]["value"]) == (value.unit, pytest.approx(value.value))
    assert [first["in_unit"]["low"], first["in_unit"]["high"]] == pytest.approx([value.low, value.high])
    assert first["identified"] == found.record.parameters[0].identified  # SI, as before
    assert told["fit"]["speed_unit"] == "rad/s" and "speed_rpm" not in told["fit"]  # a curve is told once
    assert IdentificationRecord.from_data(told) == found.record


def test_json_is_read_back_as_the_record(rotor, found):
    quick = {"relative": 0.05, "kind": "complex"}
    plan = ksmea.plan(rotor, **quick, add=2, sensors=1, n_candidate=20)
    known = ksmea.identifiability(rotor, **quick)
    for record in (plan.record, known.record, DIAGNOSIS):
        assert type(record).from_data(json.loads(json.dumps(with_units(record)))) == record
    [speeds, *_] = with_units(plan.record)["families"]
    assert speeds["steps"][0]["speed_rpm"] == pytest.approx(speeds["steps"][0]["speed"] * 30 / 3.141592653589793)
    bands = [each for each in with_units(known.record)["variations"] if each["variation"] == "band"]
    assert bands[0]["value_unit"] == "rad/s" and bands[0]["value_rpm"][0] == pytest.approx(1909.86, abs=0.01)


def test_what_has_no_units_is_told_as_it_is():
    @dataclasses.dataclass(frozen=True)
    class Mine(Record):
        size: float

    assert with_units(Mine(2.0)) == {"size": 2.0}


def test_a_field_carries_its_unit_in_its_type():
    @dataclasses.dataclass(frozen=True)
    class Mine(Record):
        speeds: "tuple[Speed, Speed] | None"
        none: "Speed | None" = None

    told = with_units(Mine((0.0, 30.0)))
    assert (told["speeds_unit"], told["speeds_rpm"]) == ("rad/s", [0.0, pytest.approx(286.479, abs=1e-3)])
    assert "none_unit" not in told
