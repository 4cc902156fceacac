"""A disk that fills up ends the experiment in one line, keeps what is finished, and the same command does the rest."""

import subprocess
import sys

import pandas as pd


def test_what_was_written_before_the_disk_was_full_is_kept(quick, table3, tmp_path):
    command = [sys.executable, "-m", "bench", *quick, "repetitions=4", "workers=2"]
    # A limit on the size of any file stands in for a full disk: writing beyond it fails in the same way.
    limited = ["bash", "-c", 'ulimit -f 24; exec "$@"', "bash", *command]
    options = {"cwd": tmp_path, "capture_output": True, "text": True, "timeout": 100}
    full = subprocess.run(limited, check=False, **options)
    assert full.returncode == 1
    assert "make room and give the same command again" in full.stderr
    assert "Traceback" not in full.stderr
    records = tmp_path / "results" / "table3" / "records" / "batch-0000.jsonl"
    kept = records.read_text().count('"event": "result"')
    assert 0 < kept < 8
    assert subprocess.run(command, check=False, **options).returncode == 0
    assert records.read_text().count('"event": "started"') <= 8 + 2  # at most those in flight were done again
    again = pd.read_csv(tmp_path / "results" / "table3" / "table3.csv")
    undisturbed = table3.table()
    assert again[again["parameter"] != "time"].equals(undisturbed[undisturbed["parameter"] != "time"])
