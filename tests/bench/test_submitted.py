"""Submitted jobs by the folder and squeue, here a stand-in for it; and jobs refuse other code."""

import dataclasses
import os

import pytest

from bench.jobs.planned_code import require_planned_code
from bench.jobs.presence import at_work
from bench.jobs.records import RecordWriter, running_sessions
from bench.jobs.submitted import forget_lost, job_states, note_ended, note_failed, note_submitted
from bench.jobs.work import Job, work
from bench.plan.plan import write_plan
from bench.plan.provenance import library_versions
from ksmea.errors import SettingError


@pytest.fixture
def squeue(tmp_path, monkeypatch):
    """Put a squeue on the path that answers so."""

    def answers(text, code=0):
        (tmp_path / "bin").mkdir(exist_ok=True)
        program = tmp_path / "bin" / "squeue"
        stream = ">&2" if code else ""
        program.write_text(f"#!/bin/sh\ncat <<'END' {stream}\n{text}\nEND\nexit {code}\n")
        program.chmod(0o755)
        monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")

    return answers


@pytest.fixture
def no_squeue(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))


def test_jobs_are_queued_running_or_lost_as_squeue_says(tmp_path, squeue):
    note_submitted(tmp_path, [f"12_{task}" for task in range(5)])
    squeue("12_0 PENDING\n12_1 RUNNING\n12_2 FAILED\n12_3 COMPLETING")
    states = ["queued", "running", "lost (FAILED)", "running", "lost (gone from the queue)"]
    assert list(job_states(tmp_path).values()) == states
    forget_lost(tmp_path)
    assert list(job_states(tmp_path)) == ["12_0", "12_1", "12_3"]


def test_a_number_that_slurm_has_forgotten_is_a_lost_job(tmp_path, squeue):
    note_submitted(tmp_path, ["12_0"])
    squeue("slurm_load_jobs error: Invalid job id specified", code=1)
    assert job_states(tmp_path) == {"12_0": "lost (gone from the queue)"}


def test_a_squeue_that_cannot_answer_loses_no_job(tmp_path, squeue):
    """While Slurm's controller restarts, whoever waits goes on waiting: no job may be taken for lost."""
    note_submitted(tmp_path, ["12_0"])
    squeue("slurm_load_jobs error: Unable to contact slurm controller (connect failure)", code=1)
    (state,) = job_states(tmp_path).values()
    assert "no sign of it" in state
    forget_lost(tmp_path)
    assert list(job_states(tmp_path)) == ["12_0"]


@pytest.mark.usefixtures("no_squeue")
def test_without_squeue_what_jobs_renew_says_which_of_them_run(tmp_path, monkeypatch):
    note_submitted(tmp_path, ["12_0", "12_1"])
    monkeypatch.setenv("SLURM_ARRAY_JOB_ID", "12")
    monkeypatch.setenv("SLURM_ARRAY_TASK_ID", "1")
    with at_work(tmp_path, 1):
        states = job_states(tmp_path)
    assert states["12_1"] == "running" and "no sign" in states["12_0"]


@pytest.mark.parametrize("first", ["the job", "who submits"])
@pytest.mark.usefixtures("no_squeue")
def test_a_job_that_ended_well_is_forgotten_however_fast_it_was(first, tmp_path):
    (tmp_path / "claims").mkdir()  # runs are dealt out before jobs are submitted
    if first == "the job":
        note_ended(tmp_path, "12_0")
        assert job_states(tmp_path) == {}
    note_submitted(tmp_path, ["12_0"])
    if first == "who submits":
        note_ended(tmp_path, "12_0")
    assert job_states(tmp_path) == {} and not any((tmp_path / "claims" / "submitted").iterdir())


def test_a_job_that_starts_again_after_all_is_done_leaves_nothing(plan, tmp_path, monkeypatch):
    monkeypatch.setattr("bench.jobs.work.require_planned_code", lambda plan: None)
    write_plan(plan, tmp_path)
    work(Job(tmp_path))
    note_ended(tmp_path, "12_0")
    assert [path.name for path in tmp_path.iterdir()] == ["plan.jsonl"]


@pytest.mark.usefixtures("no_squeue")
def test_why_a_job_failed_is_told_until_the_next_submission(tmp_path):
    note_failed(tmp_path, "12_0", "failed: no room")
    note_submitted(tmp_path, ["12_0"])
    assert job_states(tmp_path) == {"12_0": "failed: no room"}
    forget_lost(tmp_path)
    assert job_states(tmp_path) == {}


def test_runs_of_a_job_at_work_are_running_also_where_files_cannot_be_locked(tmp_path, plan, monkeypatch):
    monkeypatch.setattr("bench.jobs.records.is_held", lambda path: False)
    with at_work(tmp_path, 0) as here, RecordWriter(tmp_path, here.number, plan) as writer:
        writer.started(plan.runs[0])
        assert len(running_sessions(tmp_path)) == 1
    assert running_sessions(tmp_path) == set()


def test_a_job_refuses_other_libraries_than_planned(plan):
    here = dataclasses.replace(plan, cells=(), versions=library_versions())
    require_planned_code(here)
    other = dataclasses.replace(here, versions={**here.versions, "numpy": "1.0"})
    with pytest.raises(SettingError, match=r"expected the code and libraries of its plan .*numpy 1\.0, here") as caught:
        require_planned_code(other)
    assert "\n" not in str(caught.value)
