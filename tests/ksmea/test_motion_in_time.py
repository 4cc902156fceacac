"""Harmonic balance against integration over time: a Jeffcott rotor on springs that differ in x and y, run up and down slowly."""

from math import hypot

import numpy as np
import pytest

from integrated_rotor import integrated_jeffcott
from ksmea.nonlinear.laws import LAWS
from ksmea.nonlinear.steady_motion import SiteForce, SiteMotion, steady_force

STIFFNESS, DAMPING, UNBALANCE = np.array([1.0, 1.3]), 0.06, 0.05
SPEED = np.array([0.8, 1.0, 1.2, 1.35, 1.5])  # around the folds of x; at 1.1 that of y makes a third stable motion
ORDERS = (1, 3, 5, 7)
CUBIC, CONTACT, CLEARANCE, FRICTION = 0.5, 1.0, 0.2, 0.1


def cubic(x, y):
    size = -CUBIC * (x * x + y * y)
    return size * x, size * y


def rub(x, y):
    pressure = -CONTACT * max(1 - CLEARANCE / max(hypot(x, y), 1e-12), 0)
    return pressure * (x - FRICTION * y), pressure * (y + FRICTION * x)


CASES = {"cubic_spring": (cubic, [CUBIC]), "rub": (rub, [CONTACT, CLEARANCE, FRICTION])}


def receptance(order):
    omega = (order * SPEED)[:, None, None]
    return np.linalg.inv(np.diag(STIFFNESS) - omega**2 * np.eye(2) + 1j * omega * DAMPING * np.eye(2))[None]


def balanced(key, goes_up):
    """Harmonics 1 and 3 (n_speed, 2, 2), and what the balance leaves out (n_speed,)."""
    law, coefficients = LAWS[key], np.array([CASES[key][1]])
    alone = receptance(1) @ (UNBALANCE * SPEED[:, None] ** 2 * [1, -1j])[None, ..., None]
    further = {order: receptance(order) for order in ORDERS[1:]}
    site = SiteMotion(SPEED, alone[..., 0], receptance(1), further=further)
    found = steady_force(SiteForce(law.on_orbit, coefficients, law.stiffens(coefficients), goes_up), site)
    first, third = (
        (receptance(order) @ found.harmonics[:, :, index, :, None])[0, ..., 0] for index, order in enumerate((1, 3))
    )
    return np.stack([alone[0, ..., 0] + first, third], axis=1), found.left_out[0]


@pytest.mark.parametrize("key", CASES)
def test_up_and_down_it_is_the_motion_over_time(key):
    """To 3e-4 of the motion at 1X, and so 3X, which is a hundredth of it: free motions have died out to 1e-4 after 60 turns, and 64
    angles meet the corner of a contact to as much. Run-up and run-down jump at different speeds."""
    found = {}
    for goes_up, order in ((True, slice(None)), (False, slice(None, None, -1))):
        expected = integrated_jeffcott(STIFFNESS, DAMPING, UNBALANCE, CASES[key][0], SPEED[order])[order]
        found[goes_up], left_out = balanced(key, goes_up)
        size = np.abs(expected[:, 0]).max(axis=1)
        assert np.all(np.abs(found[goes_up] - expected).max(axis=(1, 2)) < 3e-4 * size)
        assert np.all(left_out < 0.1) and np.abs(expected[:, 1]).max() > 3e-3 * size.max()
    apart = np.abs(found[True] - found[False]).max(axis=(1, 2))
    assert np.sum(apart > 0.3 * np.abs(found[True]).max(axis=(1, 2))) >= 1
