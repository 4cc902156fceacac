"""The rows of a file as vectors, complex where it has phases, and back."""

from __future__ import annotations

import dataclasses

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.channel import Channel
from ksmea.units import DEGREE
from measurements.run_up_rows import Rows


def vectors(rows: Rows) -> Array | ComplexArray:
    """What each row says, (n_row,) µm zero to peak: complex with phases, else amplitudes."""
    amplitude = np.array(rows.amplitude)
    return amplitude if rows.phase is None else amplitude * np.exp(1j * DEGREE * np.array(rows.phase))


def with_vectors(rows: Rows, values: Array | ComplexArray, sigma: Array | None) -> Rows:
    """The rows with other vectors (n_row,) and standard deviations."""
    return dataclasses.replace(
        rows,
        amplitude=np.abs(values).tolist(),
        phase=None if rows.phase is None else np.angle(values, deg=True).tolist(),
        sigma=None if sigma is None else sigma.tolist(),
    )


def by_channel(rows: Rows) -> dict[Channel, Indices]:
    """Indices of the rows of each channel, in the order of the file."""
    found: dict[tuple[float, str, float], list[int]] = {}
    for index, channel in enumerate(rows.channel):
        found.setdefault(channel, []).append(index)
    return {Channel(*channel): np.array(indices) for channel, indices in found.items()}
