"""Structure of a linear rotor's response: the unknown impedances and the unbalance that determine it.

At one speed the dynamic stiffness is D = D₀ + Σ_i z_i E_i, with z = k + iΩc − Ω²m an unknown impedance, or a factor of a table, and E_i
of the rank of the ports that share it. By Cramer's rule the response per unbalance is N(z) / Q(z), with Q = det D the same for all
channels; N and Q are polynomials whose degree in z_i is the rank of E_i. The unbalance enters linearly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ksmea.arrays import Array, ComplexArray
from ksmea.problem.parameters import PHASE_ORIGIN, Parameters


@dataclass(frozen=True)
class UnknownImpedance:
    """Unknown impedance z = k + iΩc − Ω²m by the names of the unknowns that set it.

    A name is '' if that part is known: it moves z by a constant and changes no degree. The impedance scales a part of the dynamic
    stiffness of rank `n_port`: as many entries of bearings, or a table.
    """

    stiffness: str
    damping: str
    n_port: int
    mass: str = ""


@dataclass(frozen=True, eq=False)
class ResponseStructure:
    """Unknowns, speeds, channels and impedances of a problem.

    Its other unknowns act by its unbalance alone.

    `unbalance` is the problem's own (`Problem.unbalance`), (d,) SI → kg m by position: it costs no evaluation.
    """

    parameters: Parameters
    speed: Array  # (n_speed,) rad/s
    n_channel: int
    impedances: tuple[UnknownImpedance, ...]
    unbalance: Callable[[Array], Mapping[float, complex]]

    def impedance(self, x: Array) -> ComplexArray:
        """The unknown part of each impedance at (n, d) SI, (n_impedance, n, n_speed) N/m."""
        parts = [
            self._column(item.stiffness, x)[:, None] + 1j * self.speed * self._column(item.damping, x)[:, None]
            for item in self.impedances
        ]
        for item, part in zip(self.impedances, parts):
            if item.mass:
                part -= self.speed**2 * self._column(item.mass, x)[:, None]
        return np.stack(parts)

    def loads(self, x: Array) -> ComplexArray:
        """Factors by which unknowns scale responses, at (n, d) SI → (n, n_load).

        They are the unbalance of each plane in which it varies, and one factor for all constant unbalance.
        """
        load = self._unbalance(x)[:, self._varies]
        if np.any(self._examples[0, ~self._varies]):
            load = np.column_stack([load, np.ones(len(x))])
        return np.asarray(load * np.exp(1j * self._column(PHASE_ORIGIN, x))[:, None])

    @property
    def n_load(self) -> int:
        return len(self.loads(self.parameters.lower[None])[0])

    @cached_property
    def _examples(self) -> ComplexArray:
        """Unbalance at a few points, no whole turn apart, (3, n_plane)."""
        return self._unbalance(self.parameters.lower + np.array([[0.0], [0.3], [0.7]]) * self.parameters.width)

    @property
    def _varies(self) -> NDArray[np.bool_]:  # (n_plane,)
        return np.asarray(np.any(self._examples != self._examples[0], axis=0))

    def _unbalance(self, x: Array) -> ComplexArray:  # (n, n_plane)
        return np.array([list(self.unbalance(row).values()) for row in x], dtype=complex)

    def _column(self, name: str, x: Array) -> Array:  # (n,), 0 where no unknown has that name
        names = self.parameters.names
        return np.asarray(x[:, names.index(name)]) if name in names else np.zeros(len(x))
