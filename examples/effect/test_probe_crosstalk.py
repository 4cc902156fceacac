import numpy as np
import pytest
from probe_crosstalk import ProbeCrosstalk

import ksmea
from ksmea.measurement.channel import Channel
from ksmea.problem.alignment import through
from ksmea.testing import check_effect
from problems.three_disk import ThreeDisk

ROTOR = ksmea.load_problem("three_disk", sensors=[0.1, 0.5], n_speed=9)

test_exam = check_effect.tests(ProbeCrosstalk(), on=ThreeDisk())


def test_each_plane_with_two_probes_is_a_location():
    assert [place.position for place in ProbeCrosstalk().locations(ROTOR.problem)] == [0.1, 0.5]


def test_at_zero_it_is_the_baseline_model():
    extended = ProbeCrosstalk(position=0.1).added_to(ROTOR.problem)
    assert extended.response(np.append(ROTOR.x(), 0.0)[None])[0] == pytest.approx(ROTOR.response())


def test_a_probe_reads_a_part_of_the_other_one_at_its_plane_alone():
    plain = ROTOR.response()
    read = ProbeCrosstalk(position=0.1).added_to(ROTOR.problem).response(np.append(ROTOR.x(), 0.2)[None])[0]
    assert read[:, 0] == pytest.approx(plain[:, 0] + 0.2 * plain[:, 1])
    assert read[:, 2:] == pytest.approx(plain[:, 2:])


def test_skew_probes_are_left_as_they_are():
    skew = through(ROTOR.problem, (Channel(0.1, "45"), Channel(0.1, "-45")))
    assert not ProbeCrosstalk().locations(skew)
    read = ProbeCrosstalk(position=0.1).added_to(skew).response(np.append(ROTOR.x(), 0.2)[None])
    assert read == pytest.approx(skew.response(ROTOR.x()[None]))
