"""Two results side by side, of records alone: verdicts first, then values, those of effects among them."""

import dataclasses
import json
from pathlib import Path

import pytest

from bench.jobs.records import RecordWriter
from bench.plan.plan import all_runs, write_plan
from bench.reports.comparison.comparison import compared, text
from bench.reports.comparison.page import comparison_page
from bench.reports.comparison.sides import read_side
from ksmea.records.diagnosis import DiagnosisRecord

RECORD = DiagnosisRecord.from_data(
    json.loads((Path(__file__).parents[1] / "data/diagnosis_of_schema_2.json").read_text())
)


@pytest.fixture
def side(plan, tmp_path):
    """A diagnosis in a folder of its own, as compare reads it."""
    settings = {"study": {"name": "diagnose"}, "problem": {"name": "three_disk"}, "measurement": {"name": "file"}}
    cell = dataclasses.replace(plan.cells[0], settings=settings)
    one = dataclasses.replace(plan, name="diagnose", cells=(cell,), runs=all_runs((cell,), 1, plan.versions))

    def of(record, name):
        write_plan(one, tmp_path / name)
        with RecordWriter(tmp_path / name, 0, one) as writer:
            writer.result(one.runs[0], {"status": "done", **record.to_data()})
        return read_side(tmp_path / name)

    return of


def changed(**fields):
    return dataclasses.replace(RECORD, **fields)


NOTHING = changed(
    verdict="adequate",
    named=(),
    ambiguity_group=(),
    applied=(),
    predictive_gain=None,
    coefficients=tuple(dataclasses.replace(row, after=None) for row in RECORD.coefficients if row.before is not None),
)


def test_verdicts_that_differ_stand_first_and_values_of_an_effect_are_told(side):
    found = compared(side(RECORD, "named"), side(NOTHING, "adequate"))
    [applied] = RECORD.applied
    line = f"the findings differ: runout ({applied.location}) in a, the model explains the data in b; "
    assert found.verdict.startswith(line)
    [size] = [row.after for row in RECORD.coefficients if row.name == "runout_x"]
    row = found.unknowns.set_index("unknown").loc["runout_x"]
    assert (row["a"], row["a_low"], row["unit"]) == (size.value, size.low, size.unit)
    assert row["agrees"] == "only in a"
    said = text(found)
    assert said.splitlines()[2] == f"{found.verdict[0].upper()}{found.verdict[1:]}." and "not known" not in said
    assert "he findings differ: runout (" in comparison_page(found).decode()


def test_effects_that_both_have_are_compared_as_unknowns_are(side):
    bigger = tuple(
        dataclasses.replace(row, after=dataclasses.replace(row.after, value=2 * row.after.value, low=None, high=None))
        if row.name == "runout_x"
        else row
        for row in RECORD.coefficients
    )
    same = compared(side(RECORD, "one"), side(RECORD, "two"))
    assert same.verdict.startswith("the findings are the same: runout (")
    assert f"all {len(RECORD.coefficients)} parameters with intervals in both agree" in same.verdict
    openly = compared(side(RECORD, "three"), side(changed(coefficients=bigger), "four"))
    assert openly.unknowns.set_index("unknown").loc["runout_x", "agrees"] == "not known"  # open on both sides
