"""How benchmarks time things: pairs, agreement, what cannot run, and the processes that do the timing."""

import doctest
from pathlib import Path

import numpy as np
import pytest

from benchmarks.harness import measure, report
from benchmarks.harness.machine import this_machine
from benchmarks.harness.measure import exponent, largest_difference, measured, paired_ratio, quartiles
from benchmarks.harness.processes import NO_PEERS, started
from benchmarks.harness.row import PEERS, Contestant, Row
from benchmarks.harness.table import lines_of

HELPERS = Path(__file__).resolve().parents[1] / "helpers"
ROUNDS = 20_000  # about a millisecond


@pytest.fixture(autouse=True)
def helpers_are_found(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(HELPERS), prepend=":")


def contestant(name, task, environment="here", **settings):
    return Contestant(name, f"timed_tasks:{task}", settings, "numpy", environment)


def row(*contestants, **fields):
    return Row("group", "row", contestants, **fields)


def found(row, turns=3, peers=Path("/nowhere")):
    with started(peers) as processes:
        return measured(row, processes, turns)


def test_a_paired_ratio_does_not_see_the_machine_change():
    """Both sides three times as slow in some turns: the ratio of each turn stays, that of the medians would not."""
    pace = np.array([1.0, 3.0, 1.0, 3.0, 3.0])
    assert paired_ratio(20 * pace, 2 * pace) == (10, 10, 10)
    assert quartiles(20 * pace)[1] / quartiles(2 * pace[[0, 2, 0, 2, 2]])[1] == 30


def test_an_exponent_is_that_of_the_power_law():
    size = np.array([10, 20, 40, 80])
    assert exponent(size, 3e-6 * size**1.7) == pytest.approx(1.7)


def test_difference_is_relative_to_the_largest_value():
    assert largest_difference([1 + 1j, 100.0], [1.0, 100.0]) == 0.01
    assert np.isnan(largest_difference([[1.0]], [1.0]))


@pytest.mark.parametrize("module", [measure, report])
def test_examples_in_docstrings(module):
    result = doctest.testmod(module)
    assert result.attempted > 0 and result.failed == 0


def test_ten_times_the_work_takes_about_ten_times_as_long():
    """Between 5 and 20: the processor's clock and its caches are shared with whatever else runs."""
    ours, theirs = found(
        row(contestant("one", "busy", rounds=ROUNDS), contestant("ten", "busy", rounds=10 * ROUNDS)), turns=5
    )
    assert len(ours.seconds) == len(theirs.seconds) == 5 and not ours.skipped
    assert 5 < theirs.ratio_to(ours)[1] < 20
    assert ours.calls > theirs.calls >= 1  # short calls are timed in longer blocks
    assert ours.version.startswith("numpy 2")


def test_seconds_are_of_one_unit():
    ours, theirs = found(
        row(contestant("one", "busy", rounds=ROUNDS), contestant("a hundred", "busy", rounds=ROUNDS, units=100)),
        turns=5,
    )
    assert 1 / 200 < theirs.ratio_to(ours)[1] < 1 / 50  # the same work counted as a hundred


def test_values_are_compared_and_quality_is_the_median():
    ours, theirs, unlike = found(
        row(
            contestant("ours", "busy", rounds=10, quality=[3.0, 1.0, 2.0]),
            contestant("theirs", "busy", rounds=10, value=1.02),
            contestant("without", "busy", rounds=10, value=None),
        )
    )
    assert ours.quality == 2.0 and theirs.quality is None
    assert theirs.difference == pytest.approx(0.01)  # of the largest value, 2
    assert ours.difference is None and unlike.difference is None


@pytest.mark.parametrize(
    ("task", "reason"),
    [
        ("absent", "no_such_library is not installed: python -m benchmarks setup"),
        ("failing", "ValueError: no solution"),
        ("failing_later", "ValueError: not this time"),
        ("dying", "its process ended with 3: the last words"),
        ("hanging", "takes more than 4 s"),
        ("no_such_task", "AttributeError: module 'timed_tasks' has no attribute 'no_such_task'"),
    ],
)
def test_what_cannot_run_is_left_out_with_its_reason(task, reason):
    ours, other, third = found(
        row(
            contestant("ours", "busy", rounds=10),
            contestant("other", task),
            contestant("third", "busy", rounds=10),
            limit=4.0 if task == "hanging" else 60.0,
        )
    )
    assert other.skipped == reason and not other.seconds
    assert len(ours.seconds) == len(third.seconds) == 3 and not (ours.skipped or third.skipped)


def test_without_their_environment_peers_are_skipped():
    ours, peer = found(row(contestant("ours", "busy", rounds=10), contestant("peer", "busy", PEERS, rounds=10)))
    assert peer.skipped == NO_PEERS and ours.seconds


@pytest.mark.parametrize(("task", "reason"), [("failing", "no solution"), ("failing_later", "not this time")])
def test_without_ours_there_is_no_ratio(task, reason):
    asked = row(contestant("ours", task), contestant("other", "busy", rounds=10))
    ours, other = found(asked)
    assert ours.skipped == f"ValueError: {reason}"
    assert other.skipped == f"nothing to compare with: {ours.skipped}"
    assert [line["skipped"] for line in lines_of(asked, [ours, other], this_machine())] == [ours.skipped, other.skipped]


def test_what_libraries_print_is_no_answer():
    (ours,) = found(row(contestant("ours", "talkative")))
    assert len(ours.seconds) == 3


def test_turns_are_as_many_as_the_time_allows():
    slow = contestant("slow", "busy", rounds=50 * ROUNDS)
    assert len(found(row(slow, budget=0.0), turns=9)[0].seconds) == 3
    assert len(found(row(slow, turns=1, is_warmed=False), turns=9)[0].seconds) == 1
