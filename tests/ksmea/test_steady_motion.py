"""The steady motion under a nonlinear force: Duffing's oscillator on a circular orbit, whose amplitudes are roots of a cubic, and
whose curve folds where that has double roots."""

import numpy as np
import pytest

from ksmea.nonlinear.branches import branches
from ksmea.nonlinear.contact import cubic_spring
from ksmea.nonlinear.harmonic_balance import Balance, Harmonics
from ksmea.nonlinear.steady_motion import SiteForce, SiteMotion, steady_force

MASS, DAMPING, STIFFNESS, CUBIC, FORCE = 1.0, 0.02, 1.0, 1.0, 0.1
SPEED = np.linspace(0.6, 2.0, 57)
FORWARD = np.array([1, -1j])


def squared_amplitudes(speed, cubic):
    """Of a circular motion: a² of ((k + k₃ a² − mω²)² + (cω)²) a² = F²."""
    linear = STIFFNESS - MASS * speed**2
    roots = np.roots([cubic**2, 2 * linear * cubic, linear**2 + (DAMPING * speed) ** 2, -(FORCE**2)])
    return np.sort(roots[np.abs(roots.imag) < 1e-9].real)


def receptance(speed):
    return (1 / (STIFFNESS - MASS * speed**2 + 1j * DAMPING * speed))[:, None, None] * np.eye(2)


def squared(cubic, goes_up=True, speed=SPEED, near=None):
    per_force = receptance(speed)[None]
    alone = per_force @ (FORCE * FORWARD)
    law = SiteForce(cubic_spring, np.array([[cubic]]), np.sign([cubic]), goes_up)
    force = steady_force(law, SiteMotion(speed, alone, per_force, near))
    moved = alone + (per_force @ force.harmonics[:, :, 0, :, None])[..., 0]
    return np.abs(moved[0, :, 0]) ** 2


@pytest.mark.parametrize("cubic", [CUBIC, -0.02])  # the curve leans to higher speeds, or to lower ones
def test_a_run_up_stays_on_the_motion_that_it_comes_on(cubic):
    """Up the curve of a spring that stiffens and down that of one that softens on the largest motion, else on the smallest."""
    all_of = [squared_amplitudes(speed, cubic) for speed in SPEED]
    assert sum(len(roots) == 3 for roots in all_of) >= 5
    for goes_up in (True, False):
        expected = [roots[-1] if (cubic > 0) == goes_up else roots[0] for roots in all_of]
        assert squared(cubic, goes_up) == pytest.approx(expected, rel=1e-6)


def test_all_motions_are_found_and_the_middle_one_is_unstable():
    speed, rotation = np.array([0.8, 1.4, 1.65, 2.0]), Harmonics()
    alone = (receptance(speed) @ (FORCE * FORWARD))[:, None]
    of = receptance(speed)[:, None]
    cubic = np.full((4, 1), CUBIC)
    balance = Balance(cubic_spring, cubic, rotation, rotation.components(alone), rotation.receptance(of))
    found = branches(balance, np.sqrt(2) * FORCE / (DAMPING * speed))
    for index, one in enumerate(speed):
        here = found.point == index
        size = np.sum(found.motion[here] ** 2, axis=1) / 2
        order = np.argsort(size)
        expected = squared_amplitudes(one, CUBIC)
        assert size[order] == pytest.approx(expected, rel=1e-9)
        assert found.is_stable[here][order].tolist() == [True, False, True][: len(expected)]


def test_it_jumps_at_the_folds_of_the_closed_form():
    """At the peak a = F/(cω) and the backbone k + k₃ a² = m ω² meet; with so little damping the curve folds within 1 % of it."""
    peak = np.sqrt((1 + np.sqrt(1 + 4 * CUBIC * (FORCE / DAMPING) ** 2 / STIFFNESS**2)) / 2)
    assert len(squared_amplitudes(0.99 * peak, CUBIC)) == 3 and len(squared_amplitudes(1.01 * peak, CUBIC)) == 1
    below, above = squared(CUBIC, True, peak * np.array([0.99, 1.01]))
    assert below == pytest.approx((peak**2 * 0.99**2 - STIFFNESS) / CUBIC, rel=0.1) and above < below / 50


def test_of_several_motions_it_is_the_one_that_is_known_about():
    speed = np.array([1.4])
    low, _, high = np.sqrt(squared_amplitudes(speed[0], CUBIC))
    for amplitude in (low, high):
        near = np.array([[[FORWARD]]]) * (-amplitude if amplitude == low else -1j * amplitude)
        assert squared(CUBIC, speed=speed, near=near)[0] == pytest.approx(amplitude**2, rel=1e-6)
