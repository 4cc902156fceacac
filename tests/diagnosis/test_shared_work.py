"""Processes that share a diagnosis or a location find what one finds."""

import dataclasses

import pytest

import ksmea
from ksmea.errors import SettingError
from ksmea.numerics import parallel

pytestmark = pytest.mark.skipif(not parallel.CAN_FORK, reason="this system does not fork")


@pytest.fixture(scope="module")
def rotor():
    return ksmea.load_problem("three_disk", sensors=[0.1, 0.5], n_speed=18)


@pytest.fixture
def forks(monkeypatch):
    """The processes that were forked."""
    found = []
    fork = parallel._fork
    monkeypatch.setattr(parallel, "_fork", lambda: found.append(fork()) or found[-1])
    return found


def data_of(rotor, hidden):
    return ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", hidden=hidden, rng=3, noise_known=False)


def test_a_diagnosis_is_the_same_to_the_last_digit(rotor, forks):
    data = data_of(rotor, ["residual_bow", "timing_delay"])  # so that pairs are scanned
    effects = ["residual_bow", "timing_delay", "runout"]
    little = {"screening": 256, "starts": 4, "scan": 8, "scan_values": 2, "pairs": 2, "locate": False}
    alone = ksmea.diagnose(rotor, data, effects=effects, **little)
    assert not forks
    shared = ksmea.diagnose(rotor, data, effects=effects, workers=3, **little)
    assert len(forks) > 3
    assert dataclasses.replace(shared.record, seconds=None) == dataclasses.replace(alone.record, seconds=None)


def test_a_location_is_the_same_to_the_last_digit(rotor, forks):
    data, tried = data_of(rotor, ["unbalance"]), {"positions": [0.5, 1.0], "kinds": ["force"]}
    alone = ksmea.locate(rotor, data, **tried)
    assert not forks
    shared = ksmea.locate(rotor, data, workers=2, **tried)
    assert len(forks) > 2 and shared.record == alone.record


@pytest.mark.parametrize("workers", [0, -3, 2.5, "2", None, True])
def test_a_number_of_workers_that_is_none_is_refused(rotor, workers):
    with pytest.raises(SettingError, match=r"^workers: expected a whole number of processes from 1 on, got"):
        ksmea.locate(rotor, data_of(rotor, []), workers=workers)
