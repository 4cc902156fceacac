"""Reuse: runs shared between experiments, and evaluations of a run that was killed."""

import json
from collections import Counter

import pytest

from outside_package import outside_package
from tiers import mostly_slow


def rewrite_results(ended, key, **changes):
    """Change what is recorded of a run."""
    path = ended.output / "records" / "batch-0000.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    lines = [line | changes if line["event"] == "result" and line["key"] == key else line for line in lines]
    lines = [{name: line[name] for name in line if name != "crc32"} for line in lines]  # as of an older version
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))


def results_of(ended):
    """Record of each run, whatever session recorded it, by key."""
    identity = ("session", "taken_from", "platform", "crc32")
    return {
        event["key"]: {name: value for name, value in event.items() if name not in identity} for event in ended.events()
    }


@pytest.mark.slow
def test_finished_runs_of_the_same_key_are_taken_over(enter, cheapest, tmp_path):
    first = enter(*cheapest, "repetitions=2", "output='one, of two'", output="one, of two")
    second = enter(*cheapest, "repetitions=2", "output=two", "share=['one, of two']", output="two")
    assert second.code == 0
    assert second.events("started") == []  # nothing is computed
    assert [event["taken_from"] for event in second.events()] == ["one, of two"] * 2
    assert results_of(second) == results_of(first)
    assert second.runs().equals(first.runs())
    key = second.runs()["key"][0]
    assert "taken over from one, of two" in enter("explain", key, str(second.output)).out


@pytest.mark.slow
def test_only_what_is_not_shared_is_computed(enter, cheapest):
    enter(*cheapest, "repetitions=1", "output=one", output="one")
    enter(*cheapest, "repetitions=1", "seed=1", "output=two", output="two")
    third = enter(*cheapest, "repetitions=2", "seed=0,1,2", "output=three", "share=[one,two]", output="three")
    assert third.code == 0
    taken = {(row.seed, row.repetition) for row in third.runs().itertuples() if row.key in taken_keys(third)}
    assert taken == {(0, 0), (1, 0)}
    started = {event["key"] for event in third.events("started")}
    assert started == set(third.runs()["key"]) - taken_keys(third) and len(started) == 4


def taken_keys(ended):
    return {event["key"] for event in ended.events() if "taken_from" in event}


@pytest.mark.slow
def test_failed_runs_are_not_taken_over(enter, cheapest):
    first = enter(*cheapest, "repetitions=2", "output=one", output="one")
    failed, done = first.runs()["key"]
    rewrite_results(first, failed, status="error", error="ValueError: singular")
    second = enter(*cheapest, "repetitions=2", "output=two", "share=[one]", output="two")
    assert second.code == 0
    assert taken_keys(second) == {done}
    assert [event["key"] for event in second.events("started")] == [failed]


@pytest.mark.slow
def test_runs_of_other_settings_are_not_taken_over(enter, cheapest):
    enter(*cheapest, "repetitions=1", "output=one", output="one")
    second = enter(*cheapest, "repetitions=1", "measurement.relative=0.2", "output=two", "share=[one]", output="two")
    assert len(second.events("started")) == 1 and taken_keys(second) == set()


def test_a_folder_that_is_not_there_is_one_line(enter, cheapest, tmp_path):
    ended = enter(*cheapest, "share=[nowhere]")
    assert ended.code == 2
    assert ended.err == "error: share: expected folders of results, found none at nowhere\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_experiments_of_one_share_what_they_have_in_common(enter, cheapest):
    """The sweep's cell without a change is Table 3's; an earlier table3 of its own is shared as well."""
    words = [*cheapest, "problem.mesh=13", "measurement.relative=0.1"]
    alone = enter("+experiment=table3", *words, "repetitions=1", output="results/table3")
    both = enter("+experiment=paper", "includes=[table3,sweep]", *words, "repetitions=2", output="results/paper")
    assert alone.code == both.code == 0, both.err
    events = {name: records_of(both.output / name) for name in ("table3", "sweep")}
    table3, sweep = ([event for event in events[name] if event["event"] == "result"] for name in ("table3", "sweep"))
    assert [event.get("taken_from") for event in table3] == [str(alone.output), None]
    assert [event.get("taken_from") for event in sweep] == [str(both.output / "table3")] * 2
    assert [event["event"] for event in events["table3"] + events["sweep"]].count("started") == 1


def records_of(folder):
    return [json.loads(line) for line in (folder / "records" / "batch-0000.jsonl").read_text().splitlines()]


# A problem of someone else, an evaluation at a time: it notes each point that it has computed, and dies where a file
# beside the notes says so. The settings are those of the undisturbed run, so that both have the same key.
METADATA = "Metadata-Version: 2.1\nName: slow\nVersion: 1.0\n"
ENTRY_POINTS = "[ksmea.problems]\nslow = slow_rotor:Slow\n"
SLOW = '''
import dataclasses
import os
import signal
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ksmea import Problem, ProblemSettings
from ksmea.settings.settings import setting
from problems.three_disk import ThreeDisk


class Noted(Problem):
    def __init__(self, problem, notes):
        self.problem, self.notes = problem, notes
        self.parameters, self.speed, self.channels = problem.parameters, problem.speed, problem.channels

    def at(self, speed, channels):
        return Noted(self.problem.at(speed, channels), self.notes)

    def response(self, x):
        return np.concatenate([self.noted("response", row, self.problem.response(row[None])) for row in x])

    def sensitivity(self, x):
        return self.noted("sensitivity", x, self.problem.sensitivity(x))

    def noted(self, kind, point, answer):
        dies_at = self.notes.with_suffix(".dies_at")
        count = len(self.notes.read_text().splitlines()) if self.notes.exists() else 0
        if dies_at.exists() and count >= int(dies_at.read_text()):
            dies_at.unlink()
            os.kill(os.getpid(), signal.SIGKILL)
        with self.notes.open("a") as file:
            file.write(f"{kind} {point.tobytes().hex()}\\n")
        return answer


@dataclass(frozen=True)
class Slow(ProblemSettings):
    """The three-disk rotor, an evaluation at a time."""

    notes: str = setting("", "file of the points that it has computed")

    def build(self):
        return Noted(ThreeDisk().build(), Path(self.notes))

    def reference(self):
        return ThreeDisk().reference()
'''


@pytest.fixture
def enter_with_slow(enter, tmp_path_factory, monkeypatch):
    """The bench inside this process with the problem of someone else, which is forgotten afterwards."""
    folder = tmp_path_factory.mktemp("packages")
    information = "slow-1.0.dist-info"
    files = {
        "slow_rotor.py": SLOW,
        f"{information}/METADATA": METADATA,
        f"{information}/entry_points.txt": ENTRY_POINTS,
    }
    with outside_package(folder, monkeypatch, files):
        yield enter


POPULATION = ["method=direct", "optimizer.generations=4", "optimizer.population=10"]
LEAST_SQUARES = ["method=direct", "optimizer.screening=40", "optimizer.starts=1", "optimizer.max_iterations=10"]
SURROGATE = ["samples=25", "method.max_updates=4", "optimizer.generations=4"]
# Settings, the part of its evaluations after which the run is killed, and the points that are asked for together there.
SEARCHES = {
    "de": (POPULATION, 0.55, 1),
    "lm": (LEAST_SQUARES, 0.75, 1),
    "de under a surrogate": (SURROGATE, 0.85, 1),
}


@pytest.mark.parametrize("search", mostly_slow(SEARCHES, but=["de under a surrogate"]))
def test_a_run_whose_worker_is_killed_goes_on_where_it_was(search, enter_with_slow, tmp_path):
    settings, part, batch = SEARCHES[search]
    notes = tmp_path / "points"
    words = ["problem=slow", f"problem.notes={notes}", f"optimizer={search.split()[0]}", *settings]
    words += ["measurement.relative=0.1", "repetitions=1", "workers=1"]
    undisturbed = enter_with_slow(*words, "output=whole", output="whole")
    assert undisturbed.code == 0, undisturbed.out
    [whole] = undisturbed.events()
    of_undisturbed = noted_since(notes)

    dies_at = int(part * sum(of_undisturbed.values()))
    notes.with_suffix(".dies_at").write_text(str(dies_at))
    killed = enter_with_slow(*words, "journal=true")
    of_killed = noted_since(notes)
    assert (killed.code, sum(of_killed.values())) == (1, dies_at)
    assert killed.runs()["status"].tolist() == ["killed"] and "SIGKILL" in killed.runs()["error"][0]
    journal = killed.output / "journals" / f"{killed.runs()['key'][0]}.journal"
    assert journal.stat().st_size > 0

    finished = enter_with_slow(*words, "journal=true")
    of_finished = noted_since(notes)
    assert finished.code == 0
    [record] = [event for event in finished.events() if event["status"] in ("done", "budget")]
    for name in ("status", "parameters", "misfit", "stop", "updates", "history", "curves"):
        assert record[name] == whole[name], name
    for count in ("model_evaluations", "model_jacobians", "surrogate_evaluations"):
        assert record[count] == whole[count], count
    assert not journal.exists()
    # Every attempt makes its data anew, one evaluation at the true values; of the search nothing is computed twice but
    # those points that were asked for together with the one where it was killed.
    # The CRLB that tables state, a response and a sensitivity at the true values, is left out with a journal.
    bound = Counter(list(of_undisturbed)[:2] * 2)  # planning a plugin from outside is tried in a fork first
    data = Counter(list(of_undisturbed)[:1])
    twice = of_killed + of_finished - (of_undisturbed - bound) - data
    assert sum(twice.values()) < batch
    assert of_killed + of_finished - twice == of_undisturbed - bound + data


def noted_since(notes):
    """How often each point was computed since the last time, in the order of the first."""
    points = Counter(notes.read_text().splitlines())
    notes.unlink()
    return points


@pytest.mark.slow
def test_without_a_journal_a_killed_run_begins_again(enter_with_slow, tmp_path):
    notes = tmp_path / "points"
    words = ["problem=slow", f"problem.notes={notes}", *POPULATION, "repetitions=1", "workers=1"]
    notes.with_suffix(".dies_at").write_text("30")
    assert enter_with_slow(*words).code == 1
    of_killed = noted_since(notes)
    finished = enter_with_slow(*words)
    assert finished.code == 0 and not (finished.output / "journals").exists()
    assert of_killed < noted_since(notes)
