"""Lines of record files: one way in and one way out, whatever wrote them."""

import json
import math
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from bench.jobs.execute import execute
from bench.jobs.lines import SCHEMA, Ended, FailedRun, SessionLine, Started, line_text, read_line
from ksmea.errors import SettingError
from ksmea.records.identification import IdentificationRecord

FILE = Path("records/batch-0000.jsonl")
OLDER = Path(__file__).resolve().parents[1] / "data" / "identifications_schema_2.jsonl"


def test_a_line_is_read_as_it_was_written():
    session = SessionLine(schema=SCHEMA, session="s", began="now", commit="c0de", versions={"numpy": "2.0"})
    assert read_line(line_text(session), FILE) == session
    started = Started(schema=SCHEMA, key="k", question="q", session="s")
    again = read_line(line_text(started, {}), FILE)
    assert (again.key, again.question, again.session, again.status) == ("k", "q", "s", "killed")
    assert not again.has_result and again.content() == {"status": "killed", "error": again.error}


def test_a_result_carries_its_record():
    ended = Ended(schema=SCHEMA, key="k", question="q", session="s", status="done")
    text = line_text(ended, {"status": "done", "answer": [1, None, 0.1 + 0.2], "elapsed": 2.5})
    assert text.count(b"\n") == 1 and text.endswith(b"\n")
    again = read_line(text, FILE)
    assert again.has_result and (again.elapsed, again.error, again.taken_from) == (2.5, "", "")
    assert again.content() == {"status": "done", "answer": [1, None, 0.1 + 0.2], "elapsed": 2.5}


def test_what_is_not_finite_becomes_null_and_numbers_of_numpy_those_of_python():
    ended = Ended(schema=SCHEMA, key="k", status="done")
    content = {"status": "done", "values": [math.nan, np.float64(1.5), np.int64(2), np.bool_(True)], "open": math.inf}
    assert read_line(line_text(ended, content), FILE).content() == {
        "status": "done",
        "values": [None, 1.5, 2, True],
        "open": None,
    }


def test_a_line_with_nan_of_an_older_version_is_read():
    text = json.dumps({"schema": 2, "event": "result", "key": "k", "status": "done", "curve": [math.nan]}).encode()
    line = read_line(text, FILE)
    assert line.has_result and math.isnan(line.content()["curve"][0])


@pytest.mark.parametrize("index", [0, 1])
def test_lines_of_schema_2_hold_their_records(index):
    text = OLDER.read_bytes().splitlines()[index]
    line = read_line(text, FILE)
    assert line.key == json.loads(text)["key"] and line.elapsed == json.loads(text)["elapsed"]
    assert line.record(IdentificationRecord) == IdentificationRecord.from_data(json.loads(text))


def test_a_failed_run_is_a_record():
    record = execute({"study": {"name": "nothing"}}, {})
    failed = FailedRun.from_data(record)
    assert failed.status == "error" and failed.error.startswith("SettingError: ") and "Traceback" in failed.traceback
    line = read_line(line_text(Ended(schema=SCHEMA, key="k", status="error"), record), FILE)
    assert (line.status, line.error, line.traceback) == (failed.status, failed.error, failed.traceback)
    assert line.elapsed == record["elapsed"] and line.record(FailedRun) == failed


@pytest.mark.parametrize("place", range(0, 120, 7))
def test_a_changed_byte_makes_a_line_damaged_and_no_other_value(place):
    text = bytearray(
        line_text(Ended(schema=SCHEMA, key="k", status="done"), {"status": "done", "kxx": 0.0713, "u": 199.5})
    )
    place %= len(text) - 1
    text[place] = ord("7") if text[place] != ord("7") else ord("1")
    with suppress(SettingError):  # a newer schema
        again = read_line(bytes(text), FILE)
        # the name of the checksum is none of what it checks
        assert again is None or (again.key, again.content()["kxx"], again.content()["u"]) == ("k", 0.0713, 199.5)


def test_a_line_of_an_older_version_has_no_checksum():
    text = line_text(Ended(schema=SCHEMA, key="k", status="done"), {"status": "done", "kxx": 0.0713})
    data = json.loads(text)
    del data["crc32"]
    assert read_line(json.dumps(data).encode(), FILE).content() == {"status": "done", "kxx": 0.0713}
