"""Steady-state motion of a rotor with any force at one place of its shaft, by harmonic balance.

It uses odd harmonics. It is a route of its own, with the dense matrices and no law of `ksmea.nonlinear.laws`.
"""

import numpy as np
from scipy.optimize import root

from problems.rotor.finite_elements.assembly import assemble, displacement_row
from problems.rotor.finite_elements.loads import complex_unbalance, force_per_unbalance
from problems.rotor.response.dense import channel_rows

HARMONICS = (1, 3, 5)
N_ANGLE = 512  # of a turn
N_STEP = 20  # in which the force grows to its size


def balanced_response(rotor, speed, channels, position, force_at):
    """The part of the response that turns with the shaft, (n_speed, n_channel) m.

    `force_at(orbit, turn)` is the force, (n_angle, 2) N, of an orbit (n_angle, 2) m at angles e^{iφ} (n_angle,).
    """
    matrices = assemble(rotor)
    site = np.stack([displacement_row(rotor, position, axis) for axis in "xy"])  # (2, n_dof)
    rows = channel_rows(rotor, channels)
    excited = force_per_unbalance(rotor, speed) @ complex_unbalance(rotor)
    turn = np.exp(2j * np.pi * np.arange(N_ANGLE) / N_ANGLE)
    basis = np.stack([turn**harmonic for harmonic in HARMONICS])  # (n_harmonic, n_angle)
    found = []
    for omega, force in zip(speed, excited):
        conservative = matrices.stiffness + omega * matrices.circulatory
        dissipative = matrices.damping + omega * matrices.gyroscopic
        at = [m * omega for m in HARMONICS]
        flexible = [np.linalg.inv(conservative + 1j * w * dissipative - w**2 * matrices.mass) for w in at]
        receptance = np.stack([site @ each @ site.T for each in flexible])
        alone = np.zeros((len(HARMONICS), 2), dtype=complex)
        alone[0] = site @ flexible[0] @ force

        def acting(parts, alone=alone):
            """Harmonics of the force (n_harmonic, 2) on an orbit.

            The orbit has harmonics of (2, n_harmonic, 2) parts in units of |Q|.
            """
            real, imaginary = parts.reshape(2, len(HARMONICS), 2) * np.abs(alone).max()
            moved = real + 1j * imaginary
            orbit = (basis.T @ moved).real
            return moved, 2 * basis.conj() @ force_at(orbit, turn) / N_ANGLE

        def left(parts, size, alone=alone, receptance=receptance, acting=acting):
            moved, force = acting(parts)
            rest = (moved - alone - size * (receptance @ force[..., None])[..., 0]) / np.abs(alone).max()
            return np.concatenate([rest.real.ravel(), rest.imag.ravel()])

        parts = np.concatenate([alone.real.ravel(), alone.imag.ravel()]) / np.abs(alone).max()
        for size in np.linspace(0, 1, N_STEP + 1)[1:] ** 2:
            solved = root(left, parts, args=(size,), tol=1e-10)
            parts = solved.x
        assert np.abs(left(parts, 1.0)).max() < 1e-6, f"{omega}: {solved.message}"
        _, forces = acting(parts)
        found.append(rows @ flexible[0] @ (force + site.T @ forces[0]))
    return np.array(found)
