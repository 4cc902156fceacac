"""The synchronous response by solving with the whole dynamic stiffness: the reference route.

Sign convention: a real response is Re(q e^{iΩt}), at harmonic h Re(q e^{ihΩt}); q is complex, m, 0-peak.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from problems.rotor.finite_elements.assembly import Matrices, assemble_free, displacement_row
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.beside_node import bearing_rows
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import complex_unbalance, force_per_unbalance
from problems.rotor.finite_elements.mesh import DOF_PER_NODE
from problems.rotor.response.links import condensed, read_housings

MAX_WORK = 10**12  # n_speed n_dof³: some minutes
BLOCK = 2**23  # entries of matrices in memory at once, 134 MB of each kind


def dynamic_stiffness(matrices: Matrices, speed: Array, harmonic: float = 1.0) -> ComplexArray:
    """Dynamic stiffness D = K + ΩN + iω(C + ΩG) − ω²M at ω = hΩ, (n_speed, n_dof, n_dof) N/m.

    h is the harmonic, at each speed of rotation Ω (rad/s).
    """
    spin = np.asarray(speed)[:, None, None]
    omega = harmonic * spin
    conservative = matrices.stiffness + spin * matrices.circulatory - omega**2 * matrices.mass
    stiffness = conservative + 1j * omega * (matrices.damping + spin * matrices.gyroscopic)
    if (hysteresis := matrices.hysteresis(harmonic)) is not None:
        stiffness = stiffness + hysteresis[0] + 1j * hysteresis[1]
    return np.asarray(stiffness)


def dense_response(rotor: Rotor, speed: Array, channels: Sequence[Channel]) -> ComplexArray:
    """Unbalance response of a rotor whose numbers are all given, (n_speed, n_channel) m.

    It is computed block by block of the speeds. Housings on pedestals have degrees of freedom of their own, after the
    ones of the shaft.

    Raises `SettingError` for a rotor that would take many minutes.
    """
    n_dof, n_speed = DOF_PER_NODE * len(rotor.node_positions), len(speed)
    if n_speed > (most := max(1, MAX_WORK // n_dof**3)):
        raise SettingError(
            f"route: expected at most {most} speeds for a dense solve with {n_dof} degrees of freedom, got {n_speed}; take fewer"
            " elements or speeds, or route=reduced"
        )
    size = max(1, BLOCK // n_dof**2)
    parts = [_dense_response(rotor, speed[start : start + size], channels) for start in range(0, n_speed, size)]
    return np.concatenate(parts) if parts else np.empty((0, len(channels)), dtype=complex)


def _dense_response(rotor: Rotor, speed: Array, channels: Sequence[Channel]) -> ComplexArray:
    shaft, supported = assemble_free(rotor), rotor.supported
    n_dof = len(shaft.mass)
    housings = {index: n_dof + 2 * place for place, index in enumerate(_on_pedestals(rotor))}
    n_whole = n_dof + 2 * len(housings)
    stiffness = np.zeros((len(speed), n_whole, n_whole), dtype=complex)
    stiffness[:, :n_dof, :n_dof] = dynamic_stiffness(shaft, speed)
    for index, bearing in enumerate(supported):
        relative = _spread(rotor, bearing, n_whole)
        if bearing.pedestal is not None:
            housing = np.eye(n_whole)[[housings[index], housings[index] + 1]]
            stiffness += housing.T @ bearing.pedestal.impedance(speed) @ housing
            relative = relative - housing
        stiffness += relative.T @ bearing.impedance(speed) @ relative
    rows = np.zeros((len(channels), n_whole))
    rows[:, :n_dof] = channel_rows(rotor, channels)
    for row, channel in zip(rows, channels):
        if (carrier := rotor.housing_of(channel)) is not None:
            row[[housings[carrier], housings[carrier] + 1]] = -np.array(channel.cosines)
    force = np.zeros((len(speed), n_whole), dtype=complex)
    force[:, :n_dof] = force_per_unbalance(rotor, speed) @ complex_unbalance(rotor)
    motion = np.linalg.solve(stiffness, force[..., None])[..., 0]
    return np.asarray(motion @ rows.T)


def _spread(rotor: Rotor, bearing: Bearing, n_dof: int) -> Array:
    """Rows (2, n_dof) that read the shaft at a bearing."""
    whole = np.zeros((2, n_dof))
    dof, rows = bearing_rows(rotor, bearing)
    whole[:, dof] = rows
    return whole


def _on_pedestals(rotor: Rotor) -> list[int]:
    return [index for index, bearing in enumerate(rotor.supported) if bearing.pedestal is not None]


def bearings_and_readings(
    rotor: Rotor,
    speed: Array,
    channels: Sequence[Channel],
    impedance: ComplexArray,
    harmonic: float = 1.0,
) -> tuple[ComplexArray, ComplexArray]:
    """Dynamic stiffness that bearings, seals and pedestals add, and the rows that read the channels.

    Impedances between all ports (n_port, n_port, n_speed), N/m, are at a harmonic. The results are (n_speed, n_dof,
    n_dof) and (n_speed, n_channel, n_dof).
    """
    supported, n_dof = rotor.supported, DOF_PER_NODE * len(rotor.node_positions)
    ports = np.concatenate([np.empty((0, n_dof)), *(_spread(rotor, bearing, n_dof) for bearing in supported)])
    own = [(index, bearing.pedestal) for index, bearing in enumerate(supported) if bearing.pedestal is not None]
    on_ground = [(index, np.moveaxis(each.impedance(harmonic * speed), 0, -1)) for index, each in own]
    felt, housings = condensed(impedance, on_ground)
    rows = np.zeros((len(speed), len(channels), n_dof), dtype=complex)
    if channels:
        rows += channel_rows(rotor, channels, harmonic)
    place = {index: housing for housing, (index, _) in enumerate(own)}
    for reading in read_housings(rotor, channels, harmonic):
        moved = np.tensordot(reading.cosines, housings[place[reading.bearing]], 1)  # (n_port, n_speed)
        rows[:, reading.channel] -= moved.T @ ports
    return ports.T @ np.moveaxis(felt, -1, 0) @ ports, rows


def channel_rows(rotor: Rotor, channels: Sequence[Channel], harmonic: float = 1.0) -> Array:
    """The rows that read each channel of a motion at a harmonic, (n_channel, n_dof).

    Zeros for channels of another one.
    """
    for channel in channels:
        rotor.require_on_shaft(channel.position, "sensor")
    rows = (displacement_row(rotor, channel.position, channel.direction) for channel in channels)
    return np.stack([row if channel.harmonic == harmonic else 0.0 * row for row, channel in zip(rows, channels)])
