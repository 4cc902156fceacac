"""Workers that raise nothing, exit, crash, hang or are killed cost their own task only."""

import os
import signal
import subprocess
import sys
import time

import pytest

from bench.jobs.pool import CONTEXT, Given, Limits, _Message, _new_worker, _outcome, _stop, run_tasks


def behave(how):
    """A task of each kind; it must be importable by a worker process."""
    if how == "exit":
        os._exit(3)
    if how == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    if how == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    if how == "tell":
        print(os.getpid(), flush=True)
    if how in ("hang", "tell"):
        time.sleep(60)
    if how == "allocate":
        try:
            bytearray(8 * 2**30)
        except MemoryError:
            return {"status": "error", "error": "MemoryError"}
    if how == "fork" and os.fork() == 0:
        time.sleep(0.3)  # it goes on where the run began, and ends when the next one is under way
        how = "forked"
    if how == "slow":
        time.sleep(0.8)
    if how == "asked to end":
        for number in (signal.SIGTERM, signal.SIGUSR1, signal.SIGUSR2):
            os.kill(os.getpid(), number)
    return {"status": "done", "pid": os.getpid(), "how": how}


# Workers import this module by name to find `behave`.
sys.modules.setdefault("test_pool", sys.modules[__name__])
behave.__module__ = "test_pool"


NONE = Limits()


@pytest.fixture
def importable(monkeypatch):
    monkeypatch.syspath_prepend(os.path.dirname(__file__))
    here = os.path.dirname(__file__)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [here, os.environ.get("PYTHONPATH")])))


def outcomes(ways, workers=2, limits=NONE, started=None):
    on_start = (started if started is not None else []).append
    tasks = (Given(index, (way,)) for index, way in enumerate(ways))
    return dict(run_tasks(behave, tasks, workers, limits, on_start))


@pytest.mark.usefixtures("importable")
class TestPool:
    def test_every_task_is_done_once_and_announced_before(self):
        started = []
        done = outcomes([f"task {i}" for i in range(20)], started=started)
        assert sorted(done) == sorted(started) == list(range(20))
        assert all(done[index]["how"] == f"task {index}" for index in done)
        assert len({record["pid"] for record in done.values()}) == 2

    @pytest.mark.parametrize(
        ("how", "status", "why"),
        [
            ("exit", "killed", "exit code 3"),
            ("killed", "killed", "SIGKILL"),
            ("segfault", "killed", "SIGSEGV"),
            ("hang", "timeout", "within 1 s"),
        ],
    )
    def test_a_worker_that_dies_or_hangs_costs_its_task_only(self, how, status, why):
        done = outcomes(["a", how, "b", how, "c", "d"], limits=Limits(seconds=1))
        assert [done[index]["status"] for index in range(6)] == ["done", status, "done", status, "done", "done"]
        assert why in done[1]["error"]

    def test_memory_beyond_the_limit_is_refused_to_the_task(self):
        done = outcomes(["allocate", "a"], limits=Limits(memory=4 * 2**30))
        assert done[0]["error"] == "MemoryError"
        assert done[1]["status"] == "done"

    def test_what_a_forked_child_says_is_no_result(self):
        ways = ["fork", "slow", "fork", "slow", "a", "b"]
        done = outcomes(ways, workers=1)
        assert [done[index]["how"] for index in range(6)] == ways
        assert len({record["pid"] for record in done.values()}) == 1

    def test_a_message_of_another_task_or_process_is_passed_over(self):
        worker = _new_worker(behave, NONE)
        ours, theirs = CONTEXT.Pipe()
        worker.connection, worker.task, worker.number = ours, "the task", 2
        for task, process in ((1, worker.process.pid), (2, os.getpid())):
            theirs.send(_Message(task, process, {"status": "done"}))
        assert _outcome(worker, NONE) is None
        theirs.send(_Message(2, worker.process.pid, {"status": "done"}))
        assert _outcome(worker, NONE) == {"status": "done"}
        _stop(worker)

    def test_the_clock_of_a_task_is_monotonic(self, monkeypatch):
        monkeypatch.setattr(time, "time", lambda: 0.0)  # a wall clock set back half a century
        assert outcomes(["a", "b"], limits=Limits(seconds=20))[1]["status"] == "done"

    def test_what_asks_a_whole_job_to_end_leaves_its_workers_to_the_job(self):
        """Slurm signals all processes of a job; a run whose worker died of that would count as failed, not as stopped."""
        assert outcomes(["asked to end", "a"])[0]["status"] == "done"

    def test_tasks_that_come_later_are_asked_for_again_and_the_caller_is_not_forgotten(self):
        tasks = iter([Given(0, ("a",)), None, None, Given(1, ("slow",))])
        called = []
        done = dict(run_tasks(behave, tasks, 2, NONE, lambda task: None, (), lambda: called.append(time.monotonic())))
        assert sorted(done) == [0, 1] and len(called) >= 3

    def test_leaving_early_leaves_no_process_behind(self):
        running = run_tasks(
            behave, (Given(i, ("hang" if i else "a",)) for i in range(3)), 2, Limits(), lambda task: None
        )
        _, record = next(running)
        running.close()
        with pytest.raises(ProcessLookupError):
            os.kill(record["pid"], 0)

    @pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
    def test_whoever_kills_a_job_leaves_no_worker_at_its_run(self, number):
        command = [sys.executable, "-c", TELLING]
        with subprocess.Popen(command, cwd=os.path.dirname(__file__), stdout=subprocess.PIPE, text=True) as job:
            assert job.stdout is not None
            worker = int(job.stdout.readline())
            job.send_signal(number)
            job.wait()
            deadline = time.monotonic() + 10  # it takes milliseconds, on a busy machine more
            while is_running(worker) and time.monotonic() < deadline:
                time.sleep(0.02)
            assert not is_running(worker)


TELLING = """
from test_pool import NONE, Given, behave, run_tasks
list(run_tasks(behave, [Given(0, ("tell",))], 1, NONE, lambda task: None))
"""


def is_running(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    try:
        with open(f"/proc/{number}/stat") as status:
            return (
                status.read().rpartition(")")[2].split()[0] != "Z"
            )  # where nobody takes its ending, it stays as a name
    except (FileNotFoundError, ProcessLookupError):  # it has gone meanwhile
        return False


SCRIPT = """
from bench import main
print("begun", flush=True)
code = main.run(["+experiment=table3", "repetitions=2", "workers=2", "samples=25", "optimizer.generations=1",
                 "optimizer.population=5", "method.max_updates=1", "output=out"])
print("ended", code)
"""


@pytest.mark.slow  # tests/bench/test_from_python.py has one that calls an experiment
def test_a_script_without_a_main_guard_is_not_begun_again_by_the_workers(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False
    )
    assert done.stdout.count("begun") == 1 and done.stdout.endswith("ended 0\n"), done.stdout + done.stderr
