"""One function of many items, shared among processes.

The processes are forks of this one: they have all that the function needs as it is here, what was kept of earlier work
included, and send back what it returns. So sharing costs hundredths of a second, and nothing has to be importable. Results come
in the order of the items and are the same for any number of processes, and so is the error: that of the first item that has
one.

Items follow one another in this process where there is one worker, or a system on which libraries do not survive a fork.
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
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any, TypeVar, cast

Item = TypeVar("Item")
Result = TypeVar("Result")

CAN_FORK = sys.platform == "linux"


def for_each(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    workers: int = 1,
    *,
    known: Iterable[object] = (),
    progress: Callable[[], None] = lambda: None,
) -> list[Result]:
    """`function(item)` for every item, in their order, by at most `workers` processes. Where a result holds an object that is
    `known` here, it is that one again, and is not sent. `progress` is called after each item.

    Raises what `function` raises, its lines in a note; `ChildProcessError` where a process dies.

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
    answers: dict[int, _Answer] = {}
    with _forks(n_worker, function, items, list(known)) as forks:
        for number, answer in _answered(forks, len(items)):
            answers[number] = answer
            progress()
    return [answers[number].result() for number in range(len(items))]


def available_cores() -> int:
    """Cores that this process may use, those that Slurm has given its job included."""
    here = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(here, int(os.environ.get("SLURM_CPUS_PER_TASK", here)))


def cpu_seconds() -> float:
    """CPU time of this process and of those that it has shared work with, s."""
    return sum(os.times()[:4])


@dataclass(frozen=True)
class _Answer:
    """What became of an item: a value, or an error with the lines where it was raised."""

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
    """A fork, and this process's end of its pipe: numbers of items go there, answers come back."""

    process: int
    connection: Connection
    known: Sequence[object]

    def receive(self) -> tuple[int, _Answer]:
        number, content = self.connection.recv()
        return number, cast(_Answer, _Reader(content, self.known).load())


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
            process = _fork()
            if process == 0:
                for end in (ours, *(fork.connection for fork in forks)):
                    end.close()
                os.close(held)
                _serve(function, items, known, theirs, lifeline)
            theirs.close()
            forks.append(_Fork(process, ours, known))
        yield forks
    finally:
        os.close(held)
        os.close(lifeline)
        for fork in forks:
            fork.connection.close()
            os.kill(fork.process, signal.SIGKILL)
            os.waitpid(fork.process, 0)


def _fork() -> int:
    with warnings.catch_warnings():  # of other threads, which a fork does not have: it computes, and needs none of them
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def _answered(forks: Sequence[_Fork], n_item: int) -> Iterator[tuple[int, _Answer]]:
    """Each item's number and answer as they come; a fork has the next item as soon as it has answered."""
    by_connection = {fork.connection: fork for fork in forks}
    numbers = iter(range(n_item))
    for fork, number in zip(forks, numbers):
        fork.connection.send(number)
    for _ in range(n_item):
        fork = by_connection[cast(Connection, wait(by_connection)[0])]
        try:
            answer = fork.receive()
        except (EOFError, OSError):
            raise ChildProcessError(
                "expected all processes that share the work to live until it is done, got one that died (out of memory?);"
                " try fewer workers"
            ) from None
        following = next(numbers, None)
        if following is None:
            del by_connection[fork.connection]
        else:
            fork.connection.send(following)
        yield answer


def _serve(
    function: Callable[[Any], Any],
    items: Sequence[Any],
    known: Sequence[object],
    connection: Connection,
    lifeline: int,
) -> None:
    """A fork's life: item after item until it is killed. It never returns to where it was forked."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all of them: the process that asks decides
        threading.Thread(target=_end_with, args=(lifeline,), daemon=True).start()
        while True:
            number = connection.recv()
            connection.send((number, _sent(_answer(function, items[number]), known)))
    finally:
        os._exit(1)


def _end_with(lifeline: int) -> None:
    """End when the process that wants the results does."""
    os.read(lifeline, 1)
    os._exit(1)


def _answer(function: Callable[[Any], Any], item: Any) -> _Answer:
    try:
        return _Answer(function(item))
    except BaseException as error:
        return _Answer(error=error, lines=traceback.format_exc())


def _sent(answer: _Answer, known: Sequence[object]) -> bytes:
    """An answer as bytes; an error that no bytes can hold by what it says."""
    try:
        return _written(answer, known)
    except Exception as why:
        error = RuntimeError(f"{type(answer.error or why).__name__}: {answer.error or why}")
        return _written(_Answer(error=error, lines=answer.lines or traceback.format_exc()), known)


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
