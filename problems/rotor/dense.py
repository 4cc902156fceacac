"""The synchronous response by solving with the whole dynamic stiffness: the reference route.

Sign convention: a real response is Re(q e^{iΩt}); q is complex, m, 0-peak.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.channel import Channel
from problems.rotor.assembly import Matrices, assemble, displacement_row
from problems.rotor.data import Rotor
from problems.rotor.unbalance import complex_unbalance, force_per_unbalance


def dynamic_stiffness(matrices: Matrices, speed: Array) -> ComplexArray:
    """D(Ω) = K + ΩN + iΩ(C + ΩG) − Ω²M at each speed (rad/s), (n_speed, n_dof, n_dof) N/m."""
    omega = np.asarray(speed)[:, None, None]
    conservative = matrices.stiffness + omega * matrices.circulatory - omega**2 * matrices.mass
    return conservative + 1j * omega * (matrices.damping + omega * matrices.gyroscopic)


def dense_response(rotor: Rotor, speed: Array, channels: Sequence[Channel]) -> ComplexArray:
    """Unbalance response of a rotor whose numbers are all given, (n_speed, n_channel) m."""
    force = force_per_unbalance(rotor, speed) @ complex_unbalance(rotor)  # (n_speed, n_dof)
    motion = np.linalg.solve(dynamic_stiffness(assemble(rotor), speed), force[..., None])[..., 0]
    return motion @ channel_rows(rotor, channels).T


def channel_rows(rotor: Rotor, channels: Sequence[Channel]) -> Array:
    """The rows that read each channel, (n_channel, n_dof)."""
    for channel in channels:
        rotor.require_on_shaft(channel.position, "sensor")
    return np.stack([displacement_row(rotor, channel.position, channel.direction) for channel in channels])
