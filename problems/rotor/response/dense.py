"""The synchronous response by solving with the whole dynamic stiffness: the reference route.

Sign convention: a real response is Re(q e^{iΩt}), at harmonic h Re(q e^{ihΩt}); q is complex, m, 0-peak.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel
from problems.rotor.finite_elements.assembly import Matrices, assemble, displacement_row, node_dof
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import complex_unbalance, force_per_unbalance


def dynamic_stiffness(matrices: Matrices, speed: Array, harmonic: float = 1.0) -> ComplexArray:
    """D = K + ΩN + iω(C + ΩG) − ω²M of a motion at ω = hΩ, h the harmonic, at each speed of rotation Ω (rad/s),
    (n_speed, n_dof, n_dof) N/m."""
    spin = np.asarray(speed)[:, None, None]
    omega = harmonic * spin
    conservative = matrices.stiffness + spin * matrices.circulatory - omega**2 * matrices.mass
    return conservative + 1j * omega * (matrices.damping + spin * matrices.gyroscopic)


def dense_response(rotor: Rotor, speed: Array, channels: Sequence[Channel]) -> ComplexArray:
    """Unbalance response of a rotor whose numbers are all given, (n_speed, n_channel) m."""
    force = force_per_unbalance(rotor, speed) @ complex_unbalance(rotor)  # (n_speed, n_dof)
    motion = np.linalg.solve(dynamic_stiffness(assemble(rotor), speed), force[..., None])[..., 0]
    return motion @ channel_rows(rotor, channels).T


def add_bearings(stiffness: ComplexArray, rotor: Rotor, impedance: ComplexArray) -> None:
    """Add impedances between all ports of the bearings (n_port, n_port, n_speed), N/m, to a dynamic stiffness
    (n_speed, n_dof, n_dof)."""
    ports = np.concatenate([node_dof(rotor.node_at(bearing.position, "bearing"))[:2] for bearing in rotor.bearings])
    stiffness[:, ports[:, None], ports] += np.moveaxis(impedance, -1, 0)


def channel_rows(rotor: Rotor, channels: Sequence[Channel], harmonic: float = 1.0) -> Array:
    """The rows that read each channel of a motion at a harmonic, (n_channel, n_dof); zeros for channels of another one."""
    for channel in channels:
        rotor.require_on_shaft(channel.position, "sensor")
    rows = (displacement_row(rotor, channel.position, channel.direction) for channel in channels)
    return np.stack([row if channel.harmonic == harmonic else 0.0 * row for row, channel in zip(rows, channels)])
