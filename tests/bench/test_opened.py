"""Files that a command on results opens and loads: they grow with files, not with runs."""

import json
import subprocess
import sys

import pytest

from bench.jobs.records import RecordWriter
from bench.plan.plan import write_plan

# Audit hooks stay for the life of a process, so that each count has one of its own.
COUNT = """
import json, os, sys
opened = []
def count(event, arguments):
    if event == "open" and isinstance(arguments[0], (str, os.PathLike)):
        path = os.path.abspath(os.fspath(arguments[0]))
        if path.startswith(os.path.abspath("many")):
            opened.append(os.path.basename(path))
sys.addaudithook(count)
from bench import main
main.run(sys.argv[1:])
print(json.dumps([opened, [name for name in ("matplotlib", "pandas") if name in sys.modules]]), file=sys.stderr)
"""


@pytest.fixture
def opened(plan, tmp_path):
    """Names of the files that `status` opens of a folder with so many batches, one of its runs finished in each, and which slow
    libraries it loads."""

    def call(n_batch):
        write_plan(plan, tmp_path / "many")
        for batch in range(n_batch):
            with RecordWriter(tmp_path / "many", batch, plan) as writer:
                writer.started(plan.runs[batch])
                writer.result(plan.runs[batch], {"status": "done"})
        command = [sys.executable, "-c", COUNT, "status", "many"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        return json.loads(done.stderr.splitlines()[-1])

    return call


def test_status_opens_each_record_file_once_and_its_lock(opened):
    names, _ = opened(3)
    assert names.count("plan.jsonl") == 1
    for batch in range(3):
        assert names.count(f"batch-{batch:04d}.jsonl") == names.count(f"batch-{batch:04d}.lock") == 1


def test_status_loads_neither_tables_nor_figures(opened):
    assert opened(1)[1] == []
