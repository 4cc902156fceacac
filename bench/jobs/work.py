"""Work of a job: runs of the plan that it claims, computed in worker processes, into its record file.

The worker processes can die without harm.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.command_line.output_level import is_quiet, is_verbose
from bench.jobs.claims import Claims, are_offered
from bench.jobs.execute import execute
from bench.jobs.lines import RESULTS
from bench.jobs.planned_code import planned_plugins, require_planned_code
from bench.jobs.pool import Given, Limits, require_files, run_tasks
from bench.jobs.presence import Presence, TakenForDead, at_work
from bench.jobs.progress import Progress, experiment_log, progress_bar
from bench.jobs.records import RecordWriter, finished_keys
from bench.plan.drawn_cell import drawn_cell
from bench.plan.naming import place_text
from bench.plan.plan import Plan, Run, read_plan
from bench.plan.provenance import mentions, outside_plugins, platform_name
from ksmea.errors import shortened, visible
from ksmea.numerics.parallel import available_cores
from ksmea.plugins.files import OURS

JOURNALS = "journals"
GIGABYTE = 2**30
MOST_DRAWN = 40  # repetitions of a cell whose responses a figure compares
LONGEST_REASON = 500  # characters of a log line
SLOW_TO_IMPORT = ("scipy.stats",)  # imported where it is first used, which would be in each worker


@dataclass(frozen=True)
class Job:
    """One of the jobs that do a plan, and what its runs may use."""

    output: Path
    batch: int = 0
    workers: int | None = None
    timeout: float | None = None  # s
    memory: float | None = None  # GB
    journal: bool = False

    @property
    def limits(self) -> Limits:
        return Limits(self.timeout, None if self.memory is None else int(self.memory * GIGABYTE))


def work(job: Job) -> None:
    """Do runs that no other job has claimed until no run remains, one record per run."""
    plan = read_plan(job.output)
    require_planned_code(plan)
    if not are_offered(job.output):  # a cluster has started this job again after the others were done
        return
    with at_work(job.output, job.batch) as presence:
        claims = Claims(job.output, presence)
        if claims.are_done():
            return
        n_core = job.workers or available_cores()
        n_worker = min(n_core, len(claims.todo))
        require_files(n_worker)
        with (
            RecordWriter(job.output, presence.number, plan) as writer,
            experiment_log(job.output, plan.name, presence.number) as log,
        ):
            details = len(claims.todo), n_worker, plan.commit, platform_name()
            log.info("%d runs to do with %d workers, commit %s, on %s", *details)
            queue = _Queue(plan, job, claims, presence, n_worker, n_core // n_worker)
            with progress_bar(plan.name, len(claims.todo)) as bar, queue:
                preload = own_modules(plan)
                tasks = queue.tasks()
                for run, record in run_tasks(
                    execute, tasks, n_worker, job.limits, writer.started, preload, looked_around(queue, bar)
                ):
                    writer.result(run, record)
                    queue.ended(run)
                    if job.journal and record["status"] in RESULTS:
                        _journal(run, job).unlink(missing_ok=True)  # only a run without a result needs it again
                    bar.update()
                    line = _log_line(plan, run, record)
                    log.info("%s", line)
                    if is_verbose():
                        bar.tell(visible(line))
            log.info("job ended")


def looked_around(queue: _Queue, bar: Progress) -> Callable[[], None]:
    """Return the function that is called every half second while workers are at work."""

    def look_around() -> None:
        queue.look_around()
        bar.tick()

    return look_around


class _Queue:
    """The runs that this job has claimed and not started.

    Runs that it holds at the end of the context are free again.
    """

    def __init__(self, plan: Plan, job: Job, claims: Claims, presence: Presence, n_worker: int, n_per_run: int) -> None:
        self._plan, self._job, self._claims, self._presence = plan, job, claims, presence
        self._n_worker, self._n_per_run = n_worker, n_per_run
        self._runs = {run.key: run for run in plan.runs}
        self._plugins = planned_plugins(plan)
        self._drawn = drawn_cell(plan) if "response" in plan.report.figures else None
        self._of_cells: dict[int, tuple[dict[str, dict[str, str]], str]] = {}
        self._waiting: deque[str] = deque()
        self._began = time.monotonic()
        self._n_ended = 0

    def __enter__(self) -> None:
        pass

    def __exit__(self, exception_type: type[BaseException] | None, *exception: object) -> None:
        if exception_type is None or not issubclass(exception_type, TakenForDead):
            self._claims.release([*self._waiting])

    def tasks(self) -> Iterator[Given[Run] | None]:
        """Run after run, claimed as they are needed; None while others may yet give some back."""
        while True:
            while not self._waiting:
                if not self._claim():
                    if not self._claims.may_come_back():
                        return
                    yield None
            run = self._runs[self._waiting.popleft()]
            shows_itself = len(self._claims.todo) == 1 and not is_quiet()
            plugins, outside = self._of_cell(run.cell)
            with_fine = self._is_drawn(run)
            with_curves = run.repetition == 0 or with_fine
            arguments = (
                *_arguments(self._plan, run, self._job),
                with_curves,
                shows_itself,
                plugins,
                self._n_per_run,
                with_fine,
            )
            yield Given(run, arguments, outside)

    def _is_drawn(self, run: Run) -> bool:
        """Whether a figure may show the response of a run.

        It shows all repetitions of one cell, and of another cell the first one.
        """
        if self._drawn is None:
            return False
        return run.repetition == 0 or (run.cell == self._drawn and run.repetition < MOST_DRAWN)

    def _of_cell(self, cell: int) -> tuple[dict[str, dict[str, str]], str]:
        """The plain files that a cell's runs load, and what names all their plugins from outside.

        A file that a run does not name is not imported for it.
        """
        if cell not in self._of_cells:
            settings = self._plan.cells[cell].settings
            files = {self._plan.plugins[word] for word in self._plan.plugins if mentions(settings, word)}
            outside = " ".join([*outside_plugins(settings), *sorted(files)])
            self._of_cells[cell] = {path: each for path, each in self._plugins.items() if path in files}, outside
        return self._of_cells[cell]

    def _claim(self) -> bool:
        """Claim more runs; whether there were any."""
        seconds = (time.monotonic() - self._began) / self._n_ended if self._n_ended else None
        taken = self._claims.take(seconds, self._n_worker)
        if taken is None:
            return False
        claimed, keys = taken
        finished = finished_keys(self._job.output, self._plan) if claimed.deaths else set()
        for key in keys:
            if key in finished or key not in self._runs:
                self._claims.done(key)
            else:
                self._waiting.append(key)
        return True

    def ended(self, run: Run) -> None:
        self._n_ended += 1
        self._claims.done(run.key)

    def look_around(self) -> None:
        """Renew this job's presence, and give back what waits where others have nothing to do."""
        self._presence.renew()
        if self._claims.give_back(self._waiting):
            self._waiting.clear()


def unfinished(runs: Iterable[Run], finished: set[str]) -> list[Run]:
    """Runs without a result, each key once."""
    return list({run.key: run for run in runs if run.key not in finished}.values())


def own_modules(plan: Plan) -> list[str]:
    """Modules to preload in workers, except outside plugins, which could harm all workers at once."""
    return [*SLOW_TO_IMPORT, *(name for name in plan.modules if name.partition(".")[0] in OURS)]


def _arguments(plan: Plan, run: Run, job: Job) -> tuple[Any, ...]:
    journal = _journal(run, job) if job.journal else None
    return plan.cells[run.cell].settings, plan.seeds(run), journal


def _journal(run: Run, job: Job) -> Path:
    return job.output / JOURNALS / f"{run.key}.journal"


def _log_line(plan: Plan, run: Run, record: dict[str, Any]) -> str:
    place = " ".join(f"{axis}={place_text(value)}" for axis, value in plan.cells[run.cell].place.items())
    ending = f"{record['status']} after {record['elapsed']:.3f} s" if "elapsed" in record else record["status"]
    return f"run {run.key} ({place} repetition={run.repetition}) {ending} {shortened(str(record.get('error', '')), LONGEST_REASON)}".rstrip()
