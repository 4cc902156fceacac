"""The steady motion under a nonlinear force: Duffing's oscillator, whose amplitudes are roots of a cubic."""

import numpy as np
import pytest

from ksmea.nonlinear_forces import cubic_spring
from ksmea.steady_motion import SiteMotion, steady_motion

MASS, DAMPING, STIFFNESS, CUBIC, FORCE = 1.0, 0.02, 1.0, 1.0, 0.1
SPEED = np.linspace(0.6, 2.0, 57)


def squared_amplitudes(speed, cubic):
    """Of a circular motion: a² of ((k + k₃ a² − mω²)² + (cω)²) a² = F²."""
    linear = STIFFNESS - MASS * speed**2
    roots = np.roots([cubic**2, 2 * linear * cubic, linear**2 + (DAMPING * speed) ** 2, -(FORCE**2)])
    return np.sort(roots[np.abs(roots.imag) < 1e-9].real)


def moved(cubic, speed=SPEED, near=None):
    per_force = (1 / (STIFFNESS - MASS * speed**2 + 1j * DAMPING * speed))[None, :, None, None] * np.eye(2)
    alone = per_force @ (FORCE * np.array([1, -1j]))
    return steady_motion(cubic_spring, np.array([[cubic]]), SiteMotion(speed, alone, per_force, near))[0]


@pytest.mark.parametrize("cubic", [CUBIC, -0.02])  # hardening, and softening, where the curve leans the other way
def test_at_every_speed_it_is_one_of_the_motions_that_there_are(cubic):
    """Newton's method from the motion without the force fails at some of these speeds and goes on from a neighbour."""
    found = np.abs(moved(cubic)[:, 0]) ** 2
    for speed, squared in zip(SPEED, found):
        assert np.min(np.abs(squared_amplitudes(speed, cubic) / squared - 1)) < 1e-6


def test_of_several_motions_it_is_the_one_that_is_known_about():
    speed = np.array([1.4])
    low, _, high = np.sqrt(squared_amplitudes(speed[0], CUBIC))
    for amplitude in (low, high):
        near = np.array([[[1, -1j]]]) * (-amplitude if amplitude == low else -1j * amplitude)
        assert np.abs(moved(CUBIC, speed, near)[0, 0]) == pytest.approx(amplitude, rel=1e-6)
