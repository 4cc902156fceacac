"""Response of a rotor with something acting at one place, put into its dense matrices.

No effect of the library is used.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel
from ksmea.problem.load import Load
from problems.rotor.finite_elements.assembly import assemble
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import complex_unbalance, force_per_unbalance, unit_loads
from problems.rotor.response import dense

Series = Array | ComplexArray | int


def response_with(
    rotor: Rotor,
    speed: Array,
    channels: Sequence[Channel],
    position: float,
    quantity: str,
    load: Series,
    impedance: Series,
) -> ComplexArray:
    """Response (n_speed, n_channel) m to the unbalance and what acts at a position (m).

    That is a load (n_speed, 2), N or N m, and an impedance (n_speed, 2, 2) to the motion there.
    """
    load, impedance = np.zeros((len(speed), 2)) + load, np.zeros((len(speed), 2, 2)) + impedance
    at_site = unit_loads(rotor, [Load(position, axis, quantity) for axis in "xy"], len(speed))
    stiffness = dense.dynamic_stiffness(assemble(rotor), speed) + at_site @ impedance @ np.swapaxes(at_site, 1, 2)
    force = force_per_unbalance(rotor, speed) @ complex_unbalance(rotor) + (at_site @ load[..., None])[..., 0]
    motion = np.linalg.solve(stiffness, force[..., None])[..., 0]
    return np.asarray(motion @ dense.channel_rows(rotor, channels).T)
