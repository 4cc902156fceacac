"""Damaged lines of records: they are passed over, as before, and whoever reads the results is told."""

import pytest

from bench.jobs.records import damage_notes, damaged_lines

NOTE = "damaged lines in {path} passed over: a run whose result stood there counts as not done"


@pytest.fixture
def done(enter, cheapest, tmp_path):
    ended = enter(*cheapest, "repetitions=3", "workers=1")
    assert ended.code == 0 and damaged_lines(ended.output) == {}
    return ended


def damage(ended):
    """Two lines that are no records: one with a byte changed, one torn at the end of the file. An empty line is none."""
    path = ended.output / "records" / "batch-0000.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    last = max(number for number, line in enumerate(lines) if b'"result"' in line)
    lines[last] = b"\x00" + lines[last][1:]
    path.write_bytes(b"".join(lines) + b'\n{"schema": 3, "event": "resu')
    return path


def test_it_is_told_and_the_same_command_does_what_was_lost(done, enter, cheapest):
    path = damage(done)
    note = "note: 2 " + NOTE.format(path=path.relative_to(done.output.parents[1]))
    for command in ("collect", "status"):
        ended = enter(command, "run")
        assert ended.code == 1 and ended.out.count(note) == 1 and ended.err == ""
    again = enter(*cheapest, "repetitions=3", "workers=1")
    assert again.code == 0 and again.runs()["status"].eq("done").all() and len(again.runs()) == 3


def test_merge_and_export_tell_it_too(done, enter, cheapest, tmp_path):
    enter(*cheapest, "repetitions=3", "workers=1", "output=results/other")
    damage(done)
    merged = enter("merge", "run", "other", "--out", "whole")
    assert merged.code == 0 and merged.out.count("note: 2 damaged lines in results/run/records/batch-0000.jsonl") == 1
    assert "3 with a result" in merged.out  # the other folder has what is lost here
    exported = enter("export", "csv", "run", "--out", "table")
    assert exported.code == 0 and "note: 2 damaged lines in results/run/" in exported.out


def test_one_line_is_no_lines(tmp_path):
    (tmp_path / "records").mkdir()
    path = tmp_path / "records" / "batch-0000.jsonl"
    path.write_bytes(b"\n\nnothing\n")
    [note] = damage_notes(damaged_lines(tmp_path))
    assert note.startswith(f"1 damaged line in {path} passed over")
