"""A disk that fills up ends the experiment in one line, keeps what is finished, and the same command does the rest."""

import subprocess
import sys

import pytest


@pytest.mark.slow
def test_what_was_written_before_the_disk_was_full_is_kept(quick, table3, enter, tmp_path):
    words = [*quick, "repetitions=4", "workers=2"]
    command = [sys.executable, "-m", "bench", *words]
    # A limit on the size of any file stands in for a full disk: writing beyond it fails in the same way.
    limited = ["bash", "-c", 'ulimit -f 24; exec "$@"', "bash", *command]
    full = subprocess.run(limited, check=False, cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert full.returncode == 1
    assert "make room and give the same command again" in full.stderr
    assert "Traceback" not in full.stderr
    records = tmp_path / "results" / "table3" / "records" / "batch-0000.jsonl"
    kept = records.read_text().count('"event": "result"')
    assert 0 < kept < 8
    ended = enter(*words, output="results/table3")
    assert ended.code == 0, ended.err
    assert records.read_text().count('"event": "started"') <= 8 + 2  # at most those in flight were done again
    again, undisturbed = ended.table(), table3.table()
    assert again[again["parameter"] != "time"].equals(undisturbed[undisturbed["parameter"] != "time"])
