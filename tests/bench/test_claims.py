"""Ranges of runs that jobs claim by renaming files: every run once, whoever dies."""

import json
import os
import threading
import time

import pytest

from bench.jobs import claims, presence
from bench.jobs.claims import MAX_DEATHS, Claims, Range, deal
from bench.jobs.presence import LEASE, TakenForDead, at_work, numbers_at_work

KEYS = [f"key{number}" for number in range(100)]


@pytest.fixture
def dealt(tmp_path):
    deal(tmp_path, KEYS, shares=2)
    return tmp_path


def taken_by(job, at_least=1, seconds=None):
    taken = job.take(seconds, at_least)
    return taken[1] if taken else None


def elsewhere(there):
    """Make a job one of another machine, whose process cannot be asked about."""
    who = json.loads(there.path.read_text())
    there.path.write_text(json.dumps(who | {"place": "another machine"}))


def is_silent(there, seconds):
    """As if the job had not renewed its file for so long."""
    renewed = time.time() - seconds
    os.utime(there.path, (renewed, renewed))


def ranges(output):
    (folder,) = (path for path in (output / "claims").iterdir() if (path / "todo").is_file())
    return [found for path in folder.iterdir() if (found := Range.of(path.name)) is not None]


def test_jobs_side_by_side_take_every_run_once(dealt):
    """Eight at a time, each with a thread: what one has claimed, no other gets."""
    done = [[] for _ in range(8)]

    def job(mine):
        with at_work(dealt, 0) as here:
            own = Claims(dealt, here)
            while (keys := taken_by(own)) is not None:
                mine.extend(keys)
                for key in keys:
                    own.done(key)

    threads = [threading.Thread(target=job, args=(mine,)) for mine in done]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(key for mine in done for key in mine) == sorted(KEYS)
    assert ranges(dealt) == []


def test_a_job_takes_what_it_does_in_some_seconds_and_of_the_last_ones_a_part(dealt):
    with at_work(dealt, 0) as first:
        assert len(taken_by(Claims(dealt, first), at_least=2)) == 2  # before it knows how long runs take
        with at_work(dealt, 1) as second:
            own = Claims(dealt, second)
            assert len(taken_by(own, seconds=1.0)) == int(claims.HELD)
            assert len(taken_by(own, seconds=1e-6)) == (100 - 2 - 5) // 4  # of all that is left, among two jobs


def test_what_waits_is_given_back_once_nothing_is_free(dealt, monkeypatch):
    with at_work(dealt, 0) as first, at_work(dealt, 1) as second:
        slow, idle = Claims(dealt, first), Claims(dealt, second)
        keys = []
        while (more := taken_by(slow, at_least=100)) is not None:
            keys += more
        last = keys[-1:]
        assert taken_by(idle) is None
        monkeypatch.setattr(claims, "LOOK", 0.0)
        monkeypatch.setattr(claims, "PER_JOB", 0.0)
        assert slow.give_back(last)
        assert taken_by(idle) == last


def test_a_job_that_ended_early_leaves_nothing_claimed(dealt):
    with at_work(dealt, 0) as first:
        own = Claims(dealt, first)
        keys = taken_by(own, at_least=10)
        own.done(keys[0])
        own.release(keys[4:])
    assert {found.owner for found in ranges(dealt)} == {"free"}
    offered = {key for found in ranges(dealt) for key in KEYS[found.start : found.stop]}
    assert offered == {*KEYS}  # the one that was done too: whoever takes that range looks at the records before
    assert max(found.deaths for found in ranges(dealt) if found.start == 0) == 1


@pytest.mark.parametrize("silence, dead", [(0.5 * LEASE, False), (1.5 * LEASE, True)])
def test_claims_outlive_their_job_on_another_machine_by_a_lease(silence, dead, dealt):
    with at_work(dealt, 0) as lost, at_work(dealt, 1) as living:
        lost_keys = []
        own = Claims(dealt, lost)
        while (keys := taken_by(own, at_least=100)) is not None:
            lost_keys += keys
        elsewhere(lost)
        is_silent(lost, silence)
        assert (numbers_at_work(dealt) == {1}) is dead
        other = Claims(dealt, living)
        assert (taken_by(other) is not None) is dead
        assert other.may_come_back()


def test_a_process_that_is_gone_here_is_dead_at_once(dealt):
    with at_work(dealt, 0) as there:
        who = json.loads(there.path.read_text())
        there.path.write_text(json.dumps(who | {"process": 2**22 + 1}))  # above what Linux gives
        assert numbers_at_work(dealt) == set()


def test_a_run_that_kills_its_jobs_is_left_alone_in_the_end(tmp_path):
    """Each death is counted; after the second one the runs that it may have been are taken one by one."""
    deal(tmp_path, KEYS[:4], shares=1)
    deadly, done = KEYS[2], []
    for _ in range(20):
        with at_work(tmp_path, 0) as here:
            own = Claims(tmp_path, here)
            keys = taken_by(own, at_least=4)
            if keys is None:
                break
            if deadly not in keys:  # else it is gone, and its claims stay
                done += keys
                for key in keys:
                    own.done(key)
    assert sorted(done) == sorted({*KEYS[:4]} - {deadly})
    assert ranges(tmp_path) == [] and MAX_DEATHS == 3


def test_a_job_that_was_taken_for_dead_ends_and_claims_nothing(dealt, monkeypatch):
    monkeypatch.setattr(presence, "BEAT", 0.0)
    with at_work(dealt, 0) as here:
        own = Claims(dealt, here)
        keys = taken_by(own, at_least=10)
        for path in (dealt / "claims").glob(f"*/*.{here.name}"):
            path.rename(path.with_name(path.name.replace(here.name, "free")))
        before = sorted(map(str, ranges(dealt)))
        with pytest.raises(TakenForDead, match="was not heard of"):
            own.release(keys[5:])
        assert sorted(map(str, ranges(dealt))) == before
        here.path.unlink()
        with pytest.raises(TakenForDead):
            here.renew()


def test_numbers_are_those_that_no_job_has(tmp_path):
    with at_work(tmp_path, 0) as first, at_work(tmp_path, 0) as second, at_work(tmp_path, 1) as third:
        assert [each.number for each in (first, second, third)] == [0, 1, 2]
        assert numbers_at_work(tmp_path) == {0, 1, 2}
    assert numbers_at_work(tmp_path) == set()
