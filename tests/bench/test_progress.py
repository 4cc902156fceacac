"""The bar that a run shows of itself: where it is the only one, and at a terminal."""

import io
import sys
import time

import pytest

from bench.plan import progress
from bench.plan.progress import progress_of
from bench.plan.setup import Draw


class Terminal(io.StringIO):
    def isatty(self):
        return True


def last_line(monkeypatch, n_expected, n_done, *, with_progress=True, stream=Terminal):
    monkeypatch.setattr(sys, "stderr", stream())
    with progress_of(Draw({}, with_progress=with_progress), "study", n_expected) as step:
        for _ in range(n_done):
            step()
    return sys.stderr.getvalue().rstrip().rpartition("\r")[2]


@pytest.mark.parametrize("n_expected, n_done, shown", [(2, 3, "3/3"), (4, 1, "4/4"), (None, 2, "study: 2 steps")])
def test_it_is_full_at_the_end_whatever_was_expected(n_expected, n_done, shown, monkeypatch):
    assert shown in last_line(monkeypatch, n_expected, n_done)


def test_one_run_of_many_and_what_is_no_terminal_show_none(monkeypatch):
    assert last_line(monkeypatch, 2, 2, with_progress=False) == ""
    assert last_line(monkeypatch, 2, 2, stream=io.StringIO) == ""


def test_its_clock_goes_on_during_a_long_step(monkeypatch):
    """Drawn at the start, at five ticks or more within the step, and at the end; and by no thread afterwards."""
    monkeypatch.setattr(progress, "TICK", 0.01)
    monkeypatch.setattr(sys, "stderr", Terminal())
    with progress_of(Draw({}, with_progress=True), "study", 1) as step:
        for _ in range(1000):  # as long as it takes
            if sys.stderr.getvalue().count("0/1") > 5:
                break
            time.sleep(0.01)
        step()
    drawn = sys.stderr.getvalue()
    assert drawn.count("0/1") > 5 and "1/1" in drawn
    time.sleep(0.05)
    assert sys.stderr.getvalue() == drawn
