"""Worker processes that may raise, hang, exit, crash or be killed.

Each costs the task that it was working on, no more.

Every worker has a pipe of its own and at most one task, so that nothing is shared that a dying worker could leave
locked, and so that it is always known which task died with it. Deadlines follow the monotonic clock.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.forkserver import ensure_running
from multiprocessing.process import BaseProcess
from multiprocessing.util import register_after_fork
from types import FrameType, ModuleType
from typing import Any, Generic, TypeVar

from threadpoolctl import threadpool_limits

from bench.jobs.lines import FailedRun
from ksmea.errors import SettingError
from ksmea.numerics.parallel import descendants, end

Task = TypeVar("Task")

# A server process imports everything once and forks the workers; a new one after a crash costs milliseconds.
CONTEXT = multiprocessing.get_context("forkserver")
# Signals by which Slurm asks a job to end: the job decides what becomes of its workers.
ASKING = (signal.SIGTERM, signal.SIGUSR1, signal.SIGUSR2)
LOOK = 0.5  # s after which the caller is asked in `meanwhile`, whatever workers do
# Whoever ends a whole job kills its processes one by one. A worker that went first is no failed run, and this process is killed within
# this time, s, before it says so. 255 is what is known of a worker whose server was killed before it.
KILLED = (-signal.SIGKILL, 255)
GRACE = 0.5
FILES_OF_WORKER, SPARE_FILES = (
    3,
    16,
)  # pipes and sentinel of a worker; records, logs and modules that are read meanwhile
BEGINS = None  # what a worker says before it begins a task


@dataclass(frozen=True)
class _Message:
    """Message of a worker, `BEGINS` or a result, with the number of its task and the sending process.

    A run may fork: messages of its children are not results of the run.
    """

    task: int
    process: int
    content: dict[str, Any] | None


@dataclass(frozen=True)
class Limits:
    """Limits of one task: seconds, and bytes of address space of its process; None for no limit.

    The thread that watches over the job takes 75 MB of the address space.
    """

    seconds: float | None = None
    memory: int | None = None


@dataclass(frozen=True)
class Given(Generic[Task]):
    """A task, the arguments of the function, and what names the plugins from outside that it runs.

    It shares no worker with tasks that run others, since nobody knows what these have changed in their process.
    """

    task: Task
    arguments: tuple[Any, ...]
    outside: str = ""


@dataclass
class _Worker(Generic[Task]):
    process: BaseProcess
    connection: Connection
    task: Task | None = None
    outside: str = ""  # plugins from outside that it has run: it is not used for runs with others
    number: int = 0  # of the tasks that it was given, that of the last one
    deadline: float | None = None

    def is_busy(self) -> bool:
        return self.task is not None

    def is_usable(self) -> bool:
        return self.process.is_alive() and not self.connection.closed


def require_files(workers: int) -> None:
    """Raise `SettingError` if this process may not open the files that so many workers take."""
    limit, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        n_open = len(os.listdir("/proc/self/fd"))
    except OSError:
        return
    most = (limit - n_open - SPARE_FILES) // FILES_OF_WORKER
    if limit != resource.RLIM_INFINITY and workers > most:
        raise SettingError(
            f"expected fewer workers with at most {limit} open files (ulimit -n), got {workers}; give workers={max(most, 1)}, or raise"
            " the limit",
            setting="workers",
        )


def run_tasks(
    function: Callable[..., dict[str, Any]],
    tasks: Iterable[Given[Task] | None],
    workers: int,
    limits: Limits,
    on_start: Callable[[Task], None],
    preload: Iterable[str] = (),
    meanwhile: Callable[[], None] = lambda: None,
) -> Iterator[tuple[Task, dict[str, Any]]]:
    """Yield each task with the result of `function(*arguments)`, as results come.

    A None among the tasks means that no task is available now, and that the next one is to be requested later.
    `meanwhile` is called at least once in `LOOK` seconds. `preload` names modules that workers find loaded. A task
    whose worker died or was stopped has the data of a `FailedRun`, killed or timeout, instead.
    """
    CONTEXT.set_forkserver_preload(list(preload))
    waiting = iter(tasks)
    pool: list[_Worker[Task]] = []
    try:
        while True:
            is_last = _hand_out(waiting, pool, workers, function, limits, on_start)
            busy = [worker for worker in pool if worker.is_busy()]
            if not busy and is_last:
                return
            _wait(busy)
            meanwhile()
            for worker in busy:
                outcome = _outcome(worker, limits)
                if outcome is not None and worker.task is not None:
                    yield worker.task, outcome
                    worker.task = None
            # A busy worker stays even if it has died by now: its task must first be told what became of it.
            pool = [worker for worker in pool if worker.is_busy() or worker.is_usable()]
    finally:
        for worker in pool:
            _stop(worker)


def _hand_out(
    waiting: Iterator[Given[Task] | None],
    pool: list[_Worker[Task]],
    workers: int,
    function: Callable[..., dict[str, Any]],
    limits: Limits,
    on_start: Callable[[Task], None],
) -> bool:
    """A task for every idle worker, and new workers up to the number wanted while there are tasks.

    Returns whether there are no more tasks.
    """
    while True:
        if sum(worker.is_busy() for worker in pool) >= workers:
            return False
        try:
            following = next(waiting)
        except StopIteration:
            return True
        if following is None:
            return False
        worker = _worker_for(following.outside, pool, workers, function, limits)
        on_start(following.task)
        worker.task = following.task
        worker.outside = following.outside
        worker.number += 1
        worker.deadline = None
        try:
            worker.connection.send((worker.number, following.arguments))
        except OSError:
            pass  # it has died in the meantime: the pipe says so below


def _worker_for(
    outside: str, pool: list[_Worker[Task]], workers: int, function: Callable[..., dict[str, Any]], limits: Limits
) -> _Worker[Task]:
    """An idle worker that has run these plugins from outside, or none; else a new one.

    At most as many workers are idle as work.
    """
    idle = [worker for worker in pool if not worker.is_busy()]
    fitting = [worker for worker in idle if worker.outside in (outside, "")]
    if fitting:
        return max(fitting, key=lambda worker: worker.outside == outside)
    if len(idle) >= workers:
        _stop(idle[0])
        pool.remove(idle[0])
    worker: _Worker[Task] = _new_worker(function, limits)
    pool.append(worker)
    return worker


def _new_worker(function: Callable[..., dict[str, Any]], limits: Limits) -> _Worker[Task]:
    ours, theirs = CONTEXT.Pipe()
    process = CONTEXT.Process(target=_serve, args=(theirs, function, limits.memory), daemon=True)
    resource_tracker.ensure_running()  # which unblocks signals as it starts
    with _nothing_to_take_over():
        _start_server()
        process.start()
    theirs.close()
    return _Worker(process, ours)


def _start_server() -> None:
    """Start the server that forks workers, if none runs.

    It ignores Ctrl-C only when its modules are loaded; until then the signal is blocked there, and here for the
    milliseconds of its start.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _nothing_to_take_over() -> Iterator[None]:
    """Context in which a started process takes over nothing of this one but its paths.

    Otherwise it would import the caller's main module, which begins a script without a main guard again, and take over
    the caller's way of starting processes, which it need not know (joblib's workers have one of their own).
    """
    main, method = sys.modules["__main__"], multiprocessing.get_start_method(allow_none=True)
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ASKING)  # by the server that forks workers, too
    sys.modules["__main__"] = ModuleType("__main__")
    multiprocessing.set_start_method(None, force=True)
    try:
        yield
    finally:
        multiprocessing.set_start_method(method, force=True)
        sys.modules["__main__"] = main
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def _wait(busy: list[_Worker[Task]]) -> None:
    """Until a worker has something to say, has died, or is at its deadline, `LOOK` seconds at most."""
    deadlines = [worker.deadline - time.monotonic() for worker in busy if worker.deadline is not None]
    timeout = max(0.0, min([LOOK, *deadlines]))
    wait([handle for worker in busy for handle in (worker.connection, worker.process.sentinel)], timeout)


def _outcome(worker: _Worker[Task], limits: Limits) -> dict[str, Any] | None:
    """Outcome of a worker's task, its result or the data of a `FailedRun`; None while the task runs.

    The clock of a task starts when the worker says that it begins: starting a process takes longer than some runs.
    """
    was_alive = worker.process.is_alive()  # asked first: what a dead worker has sent is in the pipe by now
    try:
        while worker.connection.poll():
            message: _Message = worker.connection.recv()
            if (message.task, message.process) != (worker.number, worker.process.pid):
                continue
            if message.content is not BEGINS:
                return message.content
            worker.deadline = None if limits.seconds is None else time.monotonic() + limits.seconds
    except (EOFError, OSError):
        worker.process.join()
        was_alive = False
    if not was_alive:
        worker.connection.close()
        if worker.process.exitcode in KILLED:
            time.sleep(GRACE)
        return FailedRun("killed", f"the worker process {_ending(worker.process.exitcode)}").to_data()
    if worker.deadline is not None and time.monotonic() >= worker.deadline:
        _stop(worker)
        return FailedRun("timeout", f"the run did not end within {limits.seconds:g} s").to_data()
    return None


def _ending(exitcode: int | None) -> str:
    if exitcode is None or exitcode >= 0:
        return f"ended by itself with exit code {exitcode}"
    name = signal.Signals(-exitcode).name
    return f"was ended by {name}" + (" (out of memory?)" if name == "SIGKILL" else "")


def _stop(worker: _Worker[Task]) -> None:
    """End a worker, and what runs of plugins from outside have started in it."""
    children = descendants(worker.process.pid) if worker.outside and worker.process.pid else []
    worker.process.kill()
    end(children)
    worker.process.join()
    worker.connection.close()


def _let_the_parent_decide(number: int, frame: FrameType | None) -> None:
    pass


def _end_if_asked() -> None:
    """End processes that a library starts within a run as the library requests.

    `Pool.terminate` waits for that.
    """
    for asking in ASKING:
        signal.signal(asking, signal.SIG_DFL)


def _end_with_the_job() -> None:
    """End this process when the process that wants the results ends, however that happens.

    Nobody requests the results any more. Processes that the run has started go on.
    """
    job = multiprocessing.parent_process()
    if job is not None:
        job.join()
        os._exit(1)


def _serve(connection: Connection, function: Callable[..., dict[str, Any]], memory: int | None) -> None:
    """A worker's life: task after task, until the other end of the pipe is gone."""
    threading.Thread(target=_end_with_the_job, daemon=True).start()
    multiprocessing.set_start_method(None, force=True)  # as in any other process, a run may choose one
    multiprocessing.current_process().daemon = False  # libraries of a plugin may start processes of their own
    register_after_fork(_let_the_parent_decide, lambda _: _end_if_asked())
    threadpool_limits(1)  # sums in another order differ in the last digits, and the cores belong to the workers
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the parent alone decides
    for asking in ASKING:
        signal.signal(asking, _let_the_parent_decide)  # no SIG_IGN, which programs that a run starts would inherit
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT, *ASKING))
    if memory is not None:
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    own = os.getpid()
    while True:
        try:
            number, arguments = connection.recv()
        except (EOFError, OSError):
            return
        try:
            connection.send(_Message(number, os.getpid(), BEGINS))
            result = function(*arguments)
            if os.getpid() != own:
                os._exit(0)  # a child that the run has forked and forgotten: it must not take the next task either
            connection.send(_Message(number, os.getpid(), result))
        except OSError:
            return
