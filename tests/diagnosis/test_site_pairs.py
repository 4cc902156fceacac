"""Forces at two places, where one place does not explain the data."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from ksmea.location.sites import N_KEPT, fitted_pairs
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.records.location import PAIR, LocationRecord
from ksmea.show.location_text import frame, plot, text
from ksmea.studies.locate import LocationOptions, location
from problems.rotor.finite_elements.data import UnbalancePlane
from problems.rotor.response import dense
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk

TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
SENSORS = [0.1, 0.5, 1.0]
PROBLEM = ThreeDisk(sensors=SENSORS, n_speed=40).build()
FINE = ThreeDisk(mesh=26, sensors=SENSORS, n_speed=40).build()


def located(n_channel, options):
    """Two more unbalances, on the first and the third disk; the model has its own on the second."""
    rotor = rotor_at(FINE.rotor, FINE.unknowns, TRUTH)
    added = (UnbalancePlane(0.2, 8e-5, np.pi / 3), UnbalancePlane(1.0, 6e-5, -np.pi / 2))
    rotor = dataclasses.replace(rotor, unbalance=(*rotor.unbalance, *added))
    channels = FINE.channels[:n_channel]
    response = dense.dense_response(rotor, FINE.speed, channels)
    values = observe(response, "complex", Noise(0.05, 1e-7), np.random.default_rng(2))
    data = Measurement(FINE.speed, channels, values, None, "test")
    return location(Case(PROBLEM.at(FINE.speed, channels), data), np.random.default_rng(0), options=options)


FEW = LocationOptions(positions=[0.0, 0.2, 0.5, 0.8, 1.0, 1.3], kinds=["force", "moment"])


@pytest.fixture(scope="module")
def record():
    return located(6, FEW)


@pytest.mark.slow
def test_two_unbalances_on_other_disks_are_a_pair_of_forces(record):
    assert record.kind == PAIR
    assert record.sites[0].positions == (0.2, 1.0)
    assert {site.kind for site in record.sites} == {PAIR}
    assert any(site.kind == "force and moment" for site in record.candidates)  # tried beside it, and rejected


@pytest.mark.slow
def test_the_forces_of_a_pair_and_the_unknowns_beside_them_are_the_true_ones(record):
    assert record.force.positions == (0.2, 1.0) and record.force.stiffness == ()
    parts = {part.part: part for part in record.force.parts}
    for place, size, angle in ((0.2, 8e-5, np.pi / 3), (1.0, 6e-5, -np.pi / 2)):
        forward = size * np.exp(1j * angle) * FINE.speed**2
        for axis, truth in (("x", forward), ("y", -1j * forward)):
            part = parts[f"{axis} at {place:g} m"]
            held = np.mean([low <= each.real <= high for low, each, high in zip(part.real.low, truth, part.real.high)])
            assert held > 0.7  # 95 % of 40 speeds, but for errors of the unknowns that they share
    for value, each in zip(PROBLEM.parameters.in_units(TRUTH), record.coefficients):
        assert (each.over_sites.low or -np.inf) <= value <= (each.over_sites.high or np.inf)


@pytest.mark.slow
def test_a_pair_is_shown_with_both_places(record):
    assert LocationRecord.from_data(record.to_data()) == record
    said = text(record)
    assert "An unknown pair of forces that is free at every speed explains the data at " in said
    assert "At 0.2 m (disk 1) and 1 m (disk 3) the pair of forces is x at 0.2 m " in said
    first = frame(record).iloc[0]
    assert (first["position_m"], first["second_m"], first["at"]) == (0.2, 1.0, "disk 1 and disk 3")
    assert "best at 0.2 m and 1 m" in plot(record).get_suptitle()


def test_four_channels_are_too_few_for_a_pair_and_it_says_what_would_do():
    """Beside force or reading at one place; a force and a moment would take all four."""
    found = located(4, dataclasses.replace(FEW, positions=[0.0, 1.3]))
    assert found.kind == "none" and PAIR not in {site.kind for site in found.candidates}
    assert "Forces at two places take data of 5 channels or more, these have 4." in text(found)


def test_the_search_for_pairs_goes_from_a_grid_to_neighbours():
    """The best pair, of nodes that are not on the grid, is found where what is left grows with the distance from it."""
    tried = []

    def fitted(pairs):
        tried.extend(pairs)
        distance = [abs(pair.position - 7) + abs(pair.second - 22) for pair in pairs]
        return [
            SimpleNamespace(unmodelled=pair, point=SimpleNamespace(excess=away)) for pair, away in zip(pairs, distance)
        ]

    best, *others = fitted_pairs(np.arange(30.0), fitted)
    assert best.unmodelled.positions == (7.0, 22.0)
    assert len({pair.positions for pair in tried}) == len(tried) < 30 * 29 / 2 / 3
    assert len(others) == N_KEPT - 1
