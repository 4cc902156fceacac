"""Sweeps through a real Slurm of four nodes: whatever happens to a job, the tables are those of a serial run."""

import json
import os
import re
import signal
import subprocess
import sys
from contextlib import suppress
from io import StringIO
from pathlib import Path

import pandas as pd
import pytest

from bench.jobs.presence import numbers_at_work
from bench.jobs.submitted import job_states
from bench.plan.plan import read_plan
from bench.plan.report import report_named
from slurm_cluster import cluster, slurm, wait_until, why_not

pytestmark = [
    pytest.mark.skipif(bool(why_not()), reason=why_not() or "Slurm is there"),
    pytest.mark.xdist_group("slurm"),
]
pytest.importorskip("submitit", reason="hydra-submitit-launcher is not installed")

# An installed optimiser of someone else, which is slow: jobs find it as they find our own.
NAPPER = '''
import time
from dataclasses import dataclass
from pathlib import Path

from ksmea import Optimizer


@dataclass(frozen=True)
class Napper(Optimizer):
    """A few random points, after a nap, and not while there is a file `hold`."""

    def minimize(self, objective, rng):
        time.sleep(NAP)
        while Path("hold").exists():
            time.sleep(0.05)
        objective(rng.random((4, objective.dim)))
        return objective.result()
'''
# The same in a plain file, with a number from a module beside it.
FILE = (
    NAPPER.replace("Napper", "FiledNapper")
    .replace("NAP)", "0)")
    .replace("import time", "import time\nfrom points import N")
)
FILE = FILE.replace("(4,", "(N,")
METADATA = "Metadata-Version: 2.1\nName: napper\nVersion: 1.0\n"
NAP = 0.3  # s
RUNS = 24
WORDS = [
    "optimizer=napper",
    "method=direct",
    "study.intervals=none",
    f"repetitions={RUNS // 2}",
    "measurement.relative=0.05,0.1",
]
ARRAY = ["hydra/launcher=submitit_slurm", "batches=4", "hydra.launcher.mem_gb=1"]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A working directory; the package, and Slurm, for this process and all that it starts."""
    folder = tmp_path_factory.mktemp("slurm")
    site = folder / "site"
    (site / "napper-1.0.dist-info").mkdir(parents=True)
    (site / "napper-1.0.dist-info" / "METADATA").write_text(METADATA)
    (site / "napper-1.0.dist-info" / "entry_points.txt").write_text("[ksmea.optimizers]\nnapper = napper:Napper\n")
    (site / "napper.py").write_text(NAPPER.replace("NAP)", f"{NAP})"))
    paths = [str(site), *filter(None, [os.environ.get("PYTHONPATH"), str(Path(__file__).parents[2])])]
    with pytest.MonkeyPatch.context() as patch, cluster(folder / "cluster"):
        patch.setenv("PYTHONPATH", os.pathsep.join(paths))
        yield folder


@pytest.fixture(scope="module")
def call(place):
    """The bench in a process of its own."""

    def called(*words):
        done = subprocess.run(
            [sys.executable, "-m", "bench", *words], check=False, cwd=place, capture_output=True, text=True
        )
        return done.returncode, done.stdout, done.stderr

    return called


@pytest.fixture(scope="module")
def serial(call, place):
    """The tables of a run without any cluster."""
    code, _, err = call(*WORDS, "output=serial", "workers=2")
    assert code == 0, err
    return files_of(place / "serial")


def files_of(output):
    """Files that `collect` would write of the records of a folder."""
    plan = read_plan(output)
    return report_named(plan.report.table).make(plan, output).files


def without_times(name, content):
    """A table without its rows of times, a list of runs without its columns of times."""
    text = content.decode()
    if name == "runs.csv":
        frame = pd.read_csv(StringIO(text), dtype=str)
        return frame.loc[:, ~frame.columns.str.startswith(("time", "interval_seconds"))].to_csv()
    return "".join(line for line in text.splitlines(keepends=True) if not re.match(r"time,|.*,time,", line))


def assert_same_tables(output, serial):
    files = files_of(output)
    assert files.keys() == serial.keys()
    for name in (name for name in files if name.endswith(".csv")):
        assert without_times(name, files[name]) == without_times(name, serial[name])


def results_of(output):
    """The key of every result, as often as there is one."""
    lines = [line for path in (output / "records").glob("*.jsonl") for line in path.read_text().splitlines()]
    return [event["key"] for event in map(json.loads, lines) if event["event"] == "result"]


@pytest.fixture
def submitted(call, place, request):
    """A sweep that was submitted, is not waited for, and has some results by now: its folder, and Slurm's number of it."""

    def submit(*words):
        name = re.sub(r"\W+", "_", request.node.name)
        code, out, err = call(*WORDS, *ARRAY, f"output={name}", "wait=false", *words)
        assert code == 0, err
        assert f"status {place / name}" in out  # returned at once, with what to ask next
        wait_until(lambda: len(results_of(place / name)) > 2, "some runs are done")
        return place / name, re.search(r"Slurm's (\d+)", out)[1]

    yield submit
    subprocess.run(["scancel", "--user=root"], check=True)


def processes_of(job):
    """The processes of a job of an array, in this cluster and not in one that another run of the tests has started."""
    array, task = job.split("_")
    of_the_job = {
        f"{name}={value}".encode()
        for name, value in {
            "SLURM_CONF": os.environ["SLURM_CONF"],
            "SLURM_ARRAY_JOB_ID": array,
            "SLURM_ARRAY_TASK_ID": task,
        }.items()
    }
    for path in Path("/proc").glob("[0-9]*"):
        try:
            environment = (path / "environ").read_bytes().split(b"\0")
        except OSError:
            continue
        if of_the_job <= {*environment}:
            yield int(path.name)


def kill(output, job):
    for process in [*processes_of(job)]:  # found before: Slurm asks the others to end once the first is gone
        with suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)


def cancel(output, job):
    slurm("scancel", job)


def end_the_node(output, job):
    """Slurm holds it for down and requeues its job, for two minutes later; its processes are gone."""
    node = slurm("squeue", "-h", "-r", "-o", "%N", "-j", job).strip()
    slurm("scontrol", "update", f"nodename={node}", "state=down", "reason=test")
    kill(output, job)


def signal_its_limit(output, job):
    """Slurm's signal ahead of the time limit.

    The job is requeued, for two minutes later unless one says so.
    """
    slurm("scancel", "--signal=USR2", job)
    wait_until(lambda: slurm("squeue", "-h", "-r", "-o", "%T", "-j", job).strip() == "PENDING", "the job is requeued")
    assert job_states(output)[job] == "queued"
    slurm("scontrol", "update", f"jobid={job}", "StartTime=now")


TROUBLES = [kill, cancel, end_the_node, signal_its_limit]


def resume():
    """All nodes take jobs again; Slurm refuses that for those which do already."""
    subprocess.run(["scontrol", "update", "nodename=n[1-4]", "state=resume"], check=False, capture_output=True)


def test_whatever_happens_to_jobs_the_others_do_what_they_could_not(submitted, place, serial):
    """Four jobs of one sweep: one is killed, one cancelled, one loses its node, and what the last one has done by its time
    limit it need not do again when it is requeued."""
    output, array = submitted()
    (place / "hold").touch()  # no job ends before its trouble
    for number, trouble in enumerate(TROUBLES):
        trouble(output, f"{array}_{number}")
    (place / "hold").unlink()
    wait_until(lambda: {*results_of(output)} == {run.key for run in read_plan(output).runs}, "all runs are done")
    assert_same_tables(output, serial)
    assert len(results_of(output)) == RUNS  # who is killed has not written what it was at, and all else is done once
    wait_until(lambda: "running" not in job_states(output).values(), "all jobs have ended")
    states = job_states(output)
    assert states[f"{array}_0"].startswith("lost (")
    assert states[f"{array}_1"].startswith("cancelled")
    assert states.get(f"{array}_2", "queued") == "queued"  # on a slow machine it has ended well by now
    assert f"{array}_3" not in states  # requeued, and ended well
    resume()


@pytest.mark.slow
def test_a_sweep_gives_the_tables_of_a_serial_run(call, place, serial):
    code, out, err = call(*WORDS, *ARRAY, "output=waited")
    assert code == 0, err
    assert f"all {RUNS} runs of run have a result" in out
    assert_same_tables(place / "waited", serial)
    files = {name: (place / "waited" / name).read_bytes() for name in serial}
    for name in (name for name in files if name.endswith(".csv")):
        assert without_times(name, files[name]) == without_times(name, serial[name])
    assert len(list((place / "waited" / "records").glob("*.jsonl"))) == 4
    assert not (place / "waited" / "claims").exists(), f"{job_states(place / 'waited')}, {err}"


@pytest.mark.slow
def test_submitted_twice_it_is_done_once(call, place, serial):
    """While jobs are at work, others of the same experiment join them; those of another one are refused."""
    output = place / "twice"
    (place / "hold").touch()
    for _ in range(2):
        code, _, err = call(*WORDS, *ARRAY, "output=twice", "wait=false")
        assert code == 0, err
        wait_until(lambda: len(numbers_at_work(output)) == 4, "four jobs are at work, one on each node")
    refused, _, reason = call(*WORDS, "seed=1", *ARRAY, "output=twice", "wait=false")
    assert refused == 2 and "jobs of another plan are at work there" in reason
    assert len(job_states(output)) == 8
    (place / "hold").unlink()
    wait_until(lambda: not job_states(output), "all jobs have ended")
    assert len(results_of(output)) == RUNS
    assert_same_tables(output, serial)


@pytest.mark.slow
def test_whoever_waits_may_be_killed_and_the_same_command_goes_on(place, call, serial):
    command = [sys.executable, "-m", "bench", *WORDS, *ARRAY, "output=orphaned"]
    parent = subprocess.Popen(command, cwd=place, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    wait_until(lambda: results_of(place / "orphaned"), "a run is done")
    parent.kill()
    parent.communicate()
    wait_until(lambda: not job_states(place / "orphaned"), "the jobs have ended by themselves")
    code, _, err = call(*WORDS, *ARRAY, "output=orphaned")
    assert code == 0, err
    assert len(results_of(place / "orphaned")) == RUNS
    assert_same_tables(place / "orphaned", serial)


@pytest.mark.slow
def test_a_job_with_other_code_than_the_plan_computes_nothing(call, place):
    """The package was changed between planning and the start of the jobs."""
    slurm("scontrol", "update", "nodename=n[1-4]", "state=drain", "reason=test")
    code, _, err = call(*WORDS, *ARRAY, "output=changed", "wait=false")
    assert code == 0, err
    source = place / "site" / "napper.py"
    before = source.read_text()
    try:
        source.write_text(before.replace("(4,", "(5,"))
        assert set(job_states(place / "changed").values()) == {"queued"}
        resume()
        wait_until(
            lambda: all(state.startswith("failed") for state in job_states(place / "changed").values()), "jobs refuse"
        )
    finally:
        source.write_text(before)
        resume()
    (told,) = set(job_states(place / "changed").values())
    assert "expected the code and libraries of its plan" in told and "napper" in told
    assert not (place / "changed" / "records").exists()


@pytest.mark.slow
def test_files_given_by_relative_paths_travel_with_the_jobs(call, place):
    """A rotor, a campaign with the file of its runs, and a plain file of a plugin with a module beside it."""
    examples = Path(__file__).parents[2] / "docs" / "examples"
    (place / "mine").mkdir()
    for name in ("rotor.yaml", "campaign.yaml", "two_runs.csv"):
        (place / "mine" / name).write_bytes((examples / name).read_bytes())
    (place / "mine" / "filed_napper.py").write_text(FILE)
    (place / "mine" / "points.py").write_text("N = 7\n")
    words = ["plugins=[mine/filed_napper.py]", "optimizer=filed_napper", "method=direct", "study.intervals=none"]
    words += ["problem=rotor", "problem.file=mine/rotor.yaml"]
    words += ["measurement=campaign", "measurement.path=mine/campaign.yaml", "repetitions=4"]
    code, out, err = call(*words, *ARRAY, "batches=2", "output=filed")
    assert code == 0 and "all 4 runs of run have a result" in out, out + err
    assert {"file filed_napper.py", "file points.py"} <= {*read_plan(place / "filed").modules}
    code, _, err = call(*words, "output=filed_here", "workers=1")
    assert code == 0, err
    assert_same_tables(place / "filed", files_of(place / "filed_here"))
    for command in ("status", "collect"):
        assert call(command, "filed")[0] == 0  # without the file being given again
