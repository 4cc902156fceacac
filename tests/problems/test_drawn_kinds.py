"""Machines of five kinds, drawn: sound, of their kind, and alike with any mesh."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.testing import check_problem
from problems.drawn import Drawn, drawn, is_sound
from problems.drawn_kinds import KINDS, N_SPEED, PLANES

NUMBERS = range(4)
EVERY = [(kind, number) for kind in KINDS for number in NUMBERS]


@pytest.mark.parametrize(("kind", "number"), EVERY)
def test_every_machine_is_sound_and_has_critical_speeds_in_its_band(kind, number):
    instance = drawn(kind, False, number)
    problem = instance.problem
    assert is_sound(instance) and problem.is_stable(instance.x)
    criticals = problem.critical_speeds(instance.x)
    assert np.sum((criticals > problem.speed[0]) & (criticals < problem.speed[-1])) >= KINDS[kind].n_critical
    assert N_SPEED[0] <= len(problem.speed) <= N_SPEED[1] + 1
    for item, value in zip(problem.parameters, instance.x):
        assert item.lower < value < item.upper


@pytest.mark.parametrize(("kind", "number"), EVERY)
def test_disks_and_probes_are_where_their_kind_has_them(kind, number):
    rotor, channels = drawn(kind, False, number).problem.rotor, drawn(kind, False, number).problem.channels
    ends = rotor.bearings[0].position, rotor.bearings[-1].position
    places = [disk.position for disk in rotor.disks]
    outside = any(place < ends[0] for place in places), any(place > ends[1] for place in places)
    assert outside == KINDS[kind].overhung
    planes = dict.fromkeys(channel.position for channel in channels)
    assert PLANES[0] <= len(planes) <= PLANES[1] and len(channels) == 2 * len(planes)
    for plane in planes:
        one, other = (channel.angle for channel in channels if channel.position == plane)
        assert abs(np.cos(np.radians(one - other))) < 1e-9


@pytest.mark.slow
def test_unknowns_are_of_one_to_three_bearings_and_of_one_unbalance_or_two():
    counts, unbalances = set(), set()
    for kind, number in [(kind, number) for kind in KINDS for number in range(8)]:
        instance = drawn(kind, False, number)
        free = {
            target.bearing
            for item in instance.problem.unknowns
            for target in item.targets
            if hasattr(target, "bearing")
        }
        counts.add(len(free))
        unbalances.add(sum(name.startswith("u") for name in instance.true))
    assert counts == {1, 2, 3} and unbalances == {1, 2}


@pytest.mark.parametrize("kind", KINDS)
def test_a_finer_mesh_and_the_dense_solver_respond_alike(kind):
    """Elements of a 24th of the shaft: within 1 % of the largest amplitude of sharp peaks."""
    instance = drawn(kind, False, 0)
    coarse = instance.problem.response(instance.x[None])[0]
    fine = Drawn(family=kind, instance=0, mesh=96).build()
    assert sum(segment.n_element for segment in fine.rotor.segments) == 96
    values = fine.dense_response(instance.x[None])[0]
    assert 0 < np.max(np.abs(values - coarse)) < 0.01 * np.max(np.abs(coarse))


def test_the_exam_of_problems_passes_and_parts_are_refused():
    check_problem(Drawn(family="overhung", instance=1))
    with pytest.raises(SettingError, match="machine_parts: expected none with family=long, got seals"):
        Drawn(family="long", machine_parts=["seals"])
