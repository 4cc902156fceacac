"""One function of many items, shared among processes."""

import dataclasses
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from ksmea.numerics import parallel
from ksmea.numerics.parallel import CAN_FORK, NO_FORK, for_each

needs_fork = pytest.mark.skipif(not CAN_FORK, reason="this system does not fork")
EVERY_NUMBER = pytest.mark.parametrize("workers", [1, 2, 3])


@EVERY_NUMBER
def test_results_come_in_the_order_of_the_items_though_the_first_takes_longest(workers):
    def slow(number):
        time.sleep(0.2 if number == 0 else 0)
        return number**2, os.getpid()

    squares, processes = zip(*for_each(slow, range(7), workers))
    assert squares == (0, 1, 4, 9, 16, 25, 36)
    assert len(set(processes)) == (workers if CAN_FORK else 1)
    assert (os.getpid() in processes) == (workers == 1 or not CAN_FORK)


@EVERY_NUMBER
def test_no_item_and_one_item_need_no_process(workers):
    assert for_each(lambda _: os.getpid(), [], workers) == []
    assert for_each(lambda _: os.getpid(), [0], workers) == [os.getpid()]


@EVERY_NUMBER
def test_a_known_object_comes_back_as_itself_and_nothing_of_it_is_sent(workers):
    @dataclasses.dataclass
    class Local:  # no other process could import it, and it cannot be pickled
        lock: object

    shared, own = Local(lambda: None), np.arange(3.0)
    found = for_each(lambda factor: (shared, factor * own), [1, 2], workers, known=[shared])
    assert all(thing is shared for thing, _ in found)
    np.testing.assert_array_equal([array for _, array in found], [[0, 1, 2], [0, 2, 4]])


@EVERY_NUMBER
def test_the_error_is_that_of_the_first_item_that_has_one(workers):
    def function(number):
        if number >= 2:
            time.sleep(0.1 * (4 - number))  # the last one fails first
            raise np.linalg.LinAlgError(f"at {number}")
        return number

    with pytest.raises(np.linalg.LinAlgError, match=r"^at 2\b"):
        for_each(function, range(4), workers)


@needs_fork
def test_an_error_tells_where_it_was_raised():
    def named_function(_):
        raise ValueError("so")

    with pytest.raises(ValueError, match="so") as caught:
        for_each(named_function, range(2), 2)
    assert "named_function" in caught.value.__notes__[0]


@needs_fork
def test_an_error_and_a_result_that_cannot_be_sent_say_so():
    class Unsendable(Exception):
        def __reduce__(self):
            raise TypeError("never")

    def fails(_):
        raise Unsendable("what was wrong")

    with pytest.raises(RuntimeError, match=r"^Unsendable: what was wrong\b"):
        for_each(fails, range(2), 2)
    with pytest.raises(RuntimeError, match=r"pickle|local"):
        for_each(lambda _: lambda: None, range(2), 2)


@needs_fork
def test_an_error_that_another_process_cannot_make_again_says_what_it_said():
    class Two(Exception):  # as it is read back with one argument
        def __init__(self, one, other):
            super().__init__(f"{one} {other}")

    globals()["Two"] = Two
    Two.__qualname__ = "Two"

    def fails(number):
        raise Two("what", "was wrong")

    with pytest.raises(RuntimeError, match=r"^Two: what was wrong\b"):
        for_each(fails, range(2), 2)


@needs_fork
def test_after_an_error_nothing_further_is_begun(tmp_path):
    def function(number):
        (tmp_path / str(number)).touch()
        if number == 0:
            raise ValueError("the first")
        time.sleep(0.05)

    with pytest.raises(ValueError, match="the first"):
        for_each(function, range(50), 2)
    assert len(list(tmp_path.iterdir())) <= 4  # what others had in hand


@needs_fork
def test_ctrl_c_right_after_a_fork_ends_no_fork_and_lets_none_run_on(monkeypatch, heeds_sigint):
    own, fork = os.getpid(), parallel._fork

    def interrupted():
        process = fork()
        if os.getpid() != own:
            os.kill(os.getpid(), signal.SIGINT)
        return process

    monkeypatch.setattr(parallel, "_fork", interrupted)
    assert for_each(abs, range(-4, 0), 2) == [4, 3, 2, 1]


@needs_fork
def test_no_fork_begins_while_another_thread_holds_what_it_may_need():
    """A lock that stands for that of the error stream: in a fork nobody would ever release it."""
    lock, held = threading.Lock(), threading.Event()

    def hold():
        with NO_FORK, lock:
            held.set()
            time.sleep(0.3)

    thread = threading.Thread(target=hold)
    thread.start()
    held.wait()
    assert for_each(lambda _: lock.acquire(timeout=5), range(2), workers=2) == [True, True]
    thread.join()


@needs_fork
def test_processes_that_somebody_else_has_asked_for_are_no_error():
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        assert for_each(abs, range(-4, 0), 2) == [4, 3, 2, 1]
    finally:
        signal.signal(signal.SIGCHLD, before)


@EVERY_NUMBER
def test_progress_is_told_of_each_item_here(workers):
    told = []
    for_each(abs, range(5), workers, progress=lambda: told.append(os.getpid()))
    assert told == [os.getpid()] * 5


@needs_fork
def test_a_process_that_dies_does_not_hang_the_caller():
    def dies(number):
        if number == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(0.05)

    with pytest.raises(ChildProcessError, match="try fewer workers"):
        for_each(dies, range(4), 2)


@needs_fork
def test_no_process_is_left_when_the_caller_is_interrupted(tmp_path):
    def stop():
        _wait_until(lambda: len(list(tmp_path.iterdir())) == 2)
        raise KeyboardInterrupt

    def slow(number):
        (tmp_path / str(os.getpid())).touch()
        time.sleep(60 * number)

    with pytest.raises(KeyboardInterrupt):
        for_each(slow, range(20), 2, progress=stop)
    assert not any(_is_running(int(path.name)) for path in tmp_path.iterdir())


@needs_fork
def test_no_process_is_left_when_the_caller_is_killed(tmp_path):
    script = (
        "import os, pathlib, time\nfrom ksmea.numerics.parallel import for_each\n"
        f"def f(n):\n    pathlib.Path({str(tmp_path)!r}, str(os.getpid())).touch()\n    time.sleep(60)\n"
        "for_each(f, range(2), 2)"
    )
    caller = subprocess.Popen([sys.executable, "-c", script])
    try:
        _wait_until(lambda: len(list(tmp_path.iterdir())) == 2)
    finally:
        caller.kill()
        caller.wait()
    processes = [int(path.name) for path in tmp_path.iterdir()]
    _wait_until(lambda: not any(map(_is_running, processes)))


def _wait_until(holds, seconds=30.0):
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "not within the time"
        time.sleep(0.02)


def _is_running(process):
    try:
        with open(f"/proc/{process}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"  # one that nobody has asked for yet has ended
    except FileNotFoundError:
        return False
