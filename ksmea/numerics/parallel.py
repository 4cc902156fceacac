"""One function of many items, shared among processes.

The processes are forks of this one. They find everything that the function needs, including what earlier work has kept,
and send back what it returns: sharing costs hundredths of a second, and nothing has to be importable. Results come in
the order of the items and do not depend on the number of processes. Nor does the error: the first item that fails
raises it.

Items follow one another in this process where there is one worker, or a system on which libraries do not survive a fork. What
the function prints, or changes in its own process, is lost in a fork. Other threads must not hold a lock that it needs, but within
`NO_FORK`, nor share work at the same time.
"""

from __future__ import annotations

import io
import os
import pickle
import signal
import sys
import threading
import traceback
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, TypeVar, cast

Item = TypeVar("Item")
Result = TypeVar("Result")

CAN_FORK = sys.platform == "linux"

# Held by whatever thread takes locks that a fork may need, such as that of the error stream, for as long as it does
NO_FORK = threading.Lock()


def for_each(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    workers: int = 1,
    *,
    known: Iterable[object] = (),
    progress: Callable[[], None] = lambda: None,
) -> list[Result]:
    """Return `function(item)` for every item, in their order, using at most `workers` processes.

    An object of `known` in a result is not sent: the result holds the object of this process. `progress` is called
    after each item.

    Raises the error of `function`, with its traceback in a note; `ChildProcessError` if a process dies.

    >>> for_each(abs, [-1, 2, -3], workers=2)
    [1, 2, 3]
    """
    items = list(items)
    n_worker = min(workers, len(items)) if CAN_FORK else 1
    if n_worker < 2:
        found = []
        for item in items:
            found.append(function(item))
            progress()
        return found
    known = list(known)
    answers: dict[int, bytes] = {}
    with _forks(n_worker, function, items, known) as forks:
        for number, content in _answered(forks, len(items)):
            answers[number] = content
            progress()
    loaded = (_Reader(answers[number], known).load() for number in range(len(items)))  # up to the first error
    return [cast(_Answer, answer).result() for answer in loaded]


def _unseen() -> None:
    """A step that nobody follows."""


@dataclass(frozen=True)
class Workers:
    """At most `count` processes that share work, and `progress`, which is called after each item of it."""

    count: int = 1
    progress: Callable[[], None] = _unseen

    def each(
        self, function: Callable[[Item], Result], items: Iterable[Item], known: Iterable[object] = ()
    ) -> list[Result]:
        """`for_each` by these processes."""
        return for_each(function, items, self.count, known=known, progress=self.progress)

    @property
    def unseen(self) -> Workers:
        """They whose steps are not counted."""
        return Workers(self.count)


ALONE = Workers()  # this process


def available_cores() -> int:
    """Number of cores that this process may use; limited by SLURM_CPUS_PER_TASK, if it is set."""
    here = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(here, int(os.environ.get("SLURM_CPUS_PER_TASK", here)))


def cpu_seconds() -> float:
    """CPU time of this process and of its finished child processes, s."""
    return sum(os.times()[:4])


@dataclass(frozen=True)
class _Answer:
    """Outcome of an item: a value, or an error with the lines where it was raised."""

    value: Any = None
    error: BaseException | None = None
    lines: str = ""

    def result(self) -> Any:
        if self.error is None:
            return self.value
        self.error.add_note(self.lines)
        raise self.error


@dataclass(frozen=True)
class _Fork:
    """A process, and this one's end of its pipe: numbers of items go there, answers come back."""

    process: int
    connection: Connection


@contextmanager
def _forks(
    count: int, function: Callable[[Any], Any], items: Sequence[Any], known: Sequence[object]
) -> Iterator[list[_Fork]]:
    """So many forks; they are gone at the end of the block, however it ends."""
    lifeline, held = os.pipe()  # ends with this process
    forks: list[_Fork] = []
    try:
        for _ in range(count):
            ours, theirs = Pipe()
            with _interrupts_held():
                process = _fork()
                if process == 0:
                    try:
                        for end in (ours, *(fork.connection for fork in forks)):
                            end.close()
                        os.close(held)
                        _serve(function, items, known, theirs, lifeline)
                    finally:
                        os._exit(1)  # whatever happens, it never goes on with what the caller does
            forks.append(_Fork(process, ours))
            theirs.close()
        yield forks
    finally:
        os.close(held)
        os.close(lifeline)
        for fork in forks:
            fork.connection.close()
            with suppress(ProcessLookupError):  # gone, and nobody has to ask for it
                os.kill(fork.process, signal.SIGKILL)
        for fork in forks:
            with suppress(ChildProcessError):
                os.waitpid(fork.process, 0)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Ctrl-C, which reaches all processes of a terminal, waits.

    A fork is to ignore it before it meets any.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _fork() -> int:
    with NO_FORK, warnings.catch_warnings():  # of other threads, which a fork does not have
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def _answered(forks: Sequence[_Fork], n_item: int) -> Iterator[tuple[int, bytes]]:
    """Each item's number and answer as they come; a fork has the next item as soon as it has answered.

    After an error only items before its own are waited for.
    """
    waiting, first_error = deque(range(n_item)), n_item
    at_work: dict[Connection, int] = {}
    try:
        for fork in forks:
            at_work[fork.connection] = waiting.popleft()
            fork.connection.send(at_work[fork.connection])
        while any(number < first_error for number in at_work.values()):
            connection = cast(Connection, wait(at_work)[0])
            is_error, content = connection.recv()
            number = at_work.pop(connection)
            if is_error:
                first_error = min(first_error, number)
                waiting.clear()
            elif waiting:
                at_work[connection] = waiting.popleft()
                connection.send(at_work[connection])
            yield number, content
    except (EOFError, OSError):
        raise ChildProcessError(
            "expected all processes that share the work to live until it is done, got one that died (out of memory?); try"
            " fewer workers"
        ) from None


def _serve(
    function: Callable[[Any], Any],
    items: Sequence[Any],
    known: Sequence[object],
    connection: Connection,
    lifeline: int,
) -> None:
    """A fork's life: item after item until it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that asks decides
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with, args=(lifeline,), daemon=True).start()
    while True:
        answer = _answer(function, items[connection.recv()])
        connection.send(_sent(answer, known))


def _end_with(lifeline: int) -> None:
    """End when the process that wants the results does."""
    os.read(lifeline, 1)
    os._exit(1)


def _answer(function: Callable[[Any], Any], item: Any) -> _Answer:
    try:
        return _Answer(function(item))
    except BaseException as error:
        return _Answer(error=error, lines=traceback.format_exc())


def _sent(answer: _Answer, known: Sequence[object]) -> tuple[bool, bytes]:
    """Whether an answer is an error, and the answer as bytes.

    An error that cannot be made of bytes again by what it says.
    """
    try:
        content = _written(answer, known)
        if answer.error is None or type(_Reader(content, known).load().error) is type(answer.error):
            return answer.error is not None, content
        why: Exception = TypeError("an error that is another one when it is read back")
    except Exception as error:
        why = error
    substitute = RuntimeError(f"{type(answer.error or why).__name__}: {answer.error or why}")
    return True, _written(_Answer(error=substitute, lines=answer.lines or str(why)), known)


def _written(answer: _Answer, known: Sequence[object]) -> bytes:
    file = io.BytesIO()
    _Writer(file, {id(thing): number for number, thing in enumerate(known)}).dump(answer)
    return file.getvalue()


class _Writer(pickle.Pickler):
    """Writes known things by their numbers."""

    def __init__(self, file: io.BytesIO, numbers: Mapping[int, int]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._numbers = numbers

    def persistent_id(self, thing: object) -> int | None:
        return self._numbers.get(id(thing))


class _Reader(pickle.Unpickler):
    def __init__(self, content: bytes, known: Sequence[object]) -> None:
        super().__init__(io.BytesIO(content))
        self._known = known

    def persistent_load(self, number: int) -> object:
        return self._known[number]


def descendants(process: int) -> list[int]:
    """Process numbers of all processes below one.

    Empty on a system that does not list them in /proc (proc(5), children).
    """
    found: list[int] = []
    pending = [process]
    while pending:
        for path in Path("/proc", str(pending.pop()), "task").glob("*/children"):
            try:
                children = [int(each) for each in path.read_text(encoding="ascii").split()]
            except (OSError, ValueError):  # it has ended meanwhile
                continue
            found += children
            pending += children
    return found


def end(processes: Iterable[int]) -> None:
    """Kill processes, as far as they are there and may be killed."""
    for process in processes:
        with suppress(ProcessLookupError, PermissionError):
            os.kill(process, signal.SIGKILL)
