"""Shaft asymmetry: the shaft is stiffer in bending along one diameter than along the other.

Causes are keyways or slots.

With second moments of area I (1 ± ε) along axes ξ and η that turn with the shaft, ξ at an angle α past +x at t = 0, the shaft's
stiffness is larger by ε along ξ and smaller by ε along η, shear alike. In complex notation it adds κ conj(r) e^{2iΩt} with
κ = ε e^{2iα}, its unknowns. Forward 1X it couples with itself, so that a critical speed splits in two with a range between them in
which motion grows where damping is small; backward 1X becomes 3X; and the sag under the weight becomes a forward 2X, with a
peak at half of a critical speed. The growth rate of an extended model leaves that range out. Weight acts along y downwards, or as set.

It acts on the lowest bending shapes of the free rotor, of which there are `N_SHAPE`.

G. Genta, Dynamics of Rotating Systems, 2005, chapter 6; Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapter 7;
Yamamoto & Ishida, Linear and Nonlinear Rotordynamics, 2012, chapter 5.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.measurement import Measurement
from ksmea.settings.settings import setting
from ksmea.units import DEGREE
from problems.rotor.extension.effect import RotorEffect, forward_vector
from problems.rotor.extension.sizes import VectorSize
from problems.rotor.extension.turning import OF_CONJUGATE, weight_of
from problems.rotor.finite_elements.assembly import assemble_free, node_dof
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.shaft import IN_X_PLANE, IN_Y_PLANE

N_SHAPE = 4  # leave out a seventieth of what the asymmetry changes (tests/problems/test_turning_effects.py)
N_RIGID = 2  # motions of a free shaft in a plane that do not bend it
LARGEST = 0.2  # a shaft with deep slots all along
NOTICED = (0.002, 0.1)


@dataclass(frozen=True)
class ShaftAsymmetry(RotorEffect):
    """The shaft is stiffer in bending along one diameter than along the other."""

    gravity_deg: float = setting(270.0, "direction of the weight, past +x towards +y", unit="deg")

    says = (
        "The shaft's bending stiffness is {shaft_asymmetry:size} above its mean along one diameter and below it across"
    )
    check_next = "Check the shaft for keyways, slots and flats: a peak of 2X at half a critical speed confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "crack": "both make 2X at half of a critical speed; a crack opens and closes, which makes 3X of its sag too: look there",
    }
    is_scanned: ClassVar[bool] = False  # 2X grows with it from 0, where a fit finds it

    sizes = (VectorSize("shaft_asymmetry", "%", LARGEST, drawn=NOTICED),)

    def seen_in(self, measurement: Measurement) -> Self | None:
        """This effect if harmonics other than 1X were measured: at 1X alone, other effects look alike."""
        return None if all(channel.is_1x for channel in measurement.channels) else self

    def turning_rows(self, rotor: Rotor) -> Array:
        """Rows B of x, then of y, with K_s ≈ Bᵀ B in each plane.

        B = Λ^½ Vᵀ M, V being the lowest shapes that bend the shaft and Λ their squared natural frequencies.
        """
        free = assemble_free(rotor)
        in_plane = [node_dof(node)[IN_X_PLANE] for node in range(len(rotor.node_positions))]
        x_plane, mass = np.concatenate(in_plane), free.mass
        both = np.ix_(x_plane, x_plane)
        squared, shapes = scipy.linalg.eigh(
            free.stiffness[both], mass[both], subset_by_index=[N_RIGID, N_RIGID + N_SHAPE - 1]
        )
        reading = np.sqrt(squared)[:, None] * (shapes.T @ mass[both])
        rows = np.zeros((2, N_SHAPE, len(mass)))
        rows[0][:, x_plane] = reading
        for node in range(len(rotor.node_positions)):
            rows[1][:, node_dof(node)[IN_Y_PLANE]] = reading[:, 2 * node : 2 * node + 2] * [1.0, -1.0]
        return rows.reshape(2 * N_SHAPE, -1)

    def turning_stiffness(self, rotor: Rotor, theta: Array) -> ComplexArray:
        found = np.zeros((len(theta), 3, 2 * N_SHAPE, 2 * N_SHAPE), dtype=complex)
        found[:, 2] = forward_vector(theta)[:, None, None] / 2 * np.kron(OF_CONJUGATE, np.eye(N_SHAPE))
        return found

    def weight(self, rotor: Rotor) -> Array:
        return weight_of(rotor, self.gravity_deg * DEGREE)
