"""Damping that turns with the shaft: nothing on a circular orbit, where it meets the circulatory force that comes with it."""

import numpy as np
import pytest

from ksmea.plugins import registry
from problems.rotor.finite_elements.assembly import assemble_free
from problems.three_disk import ThreeDisk, three_disk_rotor

PLAIN = ThreeDisk(sensors=[0.1, 0.2, 0.5], n_speed=14).build()
DAMPING = registry.create("effect", "internal_damping", {})


@pytest.mark.parametrize("kyy, least, most", [(6e7, 0.0, 1e-8), (9e7, 1e-2, np.inf)])
def test_internal_damping_does_nothing_on_a_circular_orbit(kyy, least, most):
    values = np.array([6e7, kyy, 500.0, 500.0, 2e-4])
    plain = PLAIN.response(values[None])[0]
    damped = DAMPING.added_to(PLAIN).response(np.append(values, 5e-5)[None])[0]
    assert least <= np.abs(damped - plain).max() / np.abs(plain).max() < most  # 1e-8: rounding at a sharp peak


def test_damping_and_circulatory_force_cancel_on_a_forward_circular_vector():
    rotor = DAMPING.rotor(three_disk_rotor(13), np.array([1e-4]))
    matrices = assemble_free(rotor)
    rng = np.random.default_rng(5)
    deflection, slope = rng.standard_normal((2, len(rotor.node_positions)))
    forward = np.stack([deflection, -1j * deflection, 1j * slope, slope], axis=-1).ravel()
    damping = 1j * matrices.damping @ forward
    assert np.abs(damping + matrices.circulatory @ forward).max() < 1e-12 * np.abs(damping).max()
    assert np.abs(damping + matrices.circulatory @ forward.conj()).max() > 0.1 * np.abs(damping).max()
