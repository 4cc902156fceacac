"""The likelihood of the noise alone: the part of the joint one that is the noise's, for every kind of data."""

import dataclasses

import numpy as np
import pytest

from campaigns import TRIAL, TRUTH, layout_of, measured
from ksmea.alignment import aligned
from ksmea.difference_likelihood import likelihood_of
from ksmea.measurement import Noise
from ksmea.model import Model
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.5]).build()
SPEED = np.linspace(200, 1500, 9)
RUNS = [("bare", ()), ("one", (TRIAL,))]


def likelihood(kind, own_noise, reference):
    layout = layout_of(PROBLEM, [SPEED, SPEED * (1 + 2e-4)], RUNS, kind)
    data = measured(PROBLEM, layout, noise=Noise(0.03, 5e-8))
    campaign = dataclasses.replace(data.campaign, own_noise=own_noise, reference=reference)
    data = dataclasses.replace(data, campaign=campaign)
    return likelihood_of(Model(aligned(PROBLEM, data)), data)


@pytest.mark.parametrize("own_noise", [False, True])
@pytest.mark.parametrize(("kind", "reference"), [("complex", None), ("amplitude", None), ("complex", "bare")])
def test_it_is_the_noise_s_part_of_the_joint_one(kind, reference, own_noise):
    joint = likelihood(kind, own_noise, reference)
    problem, n_level = joint.model.problem, 2 if own_noise else 1
    u = problem.parameters.to_cube(np.array([TRUTH[name] for name in problem.parameters.names])) + 2e-4
    theta = np.concatenate([u, np.tile(np.log([0.02, 8e-8]), n_level)])
    expected = joint.at(theta)
    alone = joint.noise_alone(joint.model.response(u[None])[0], u)
    found = alone.at(theta[joint.d :])
    assert found.deviance == pytest.approx(expected.deviance, rel=1e-12)
    assert found.gradient == pytest.approx(expected.gradient[joint.d :], rel=1e-9)
    assert found.information == pytest.approx(expected.information[joint.d :, joint.d :], rel=1e-9)
