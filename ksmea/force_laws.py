"""Laws that a force on the shaft may follow: from speed alone, or from the motion of its site.

A law has a few real coefficients c: f = Σ c g(Ω), or f = −K q with K = Σ c K(Ω) and q the motion of the site, which the
force moves along:

    q = Q + G f,   f = −(1 + K G)⁻¹ K Q,

with Q the motion without it and G that per unit of it.

Sign convention: a real force is Re(f e^{iΩt}); a rotating vector is (1, −i) in (x, y).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.channel import DIRECTIONS
from ksmea.units import GRAM_MILLIMETRE

FORWARD = np.array([1, -1j])
AXES = np.stack([np.diag([1.0, 0.0]), np.diag([0.0, 1.0])])
CROSS = np.array([[[0.0, 1.0], [-1.0, 0.0]]])


@dataclass(frozen=True)
class Law:
    """A law by its key in settings and its name for people; `coefficients` have a name, a unit and its size in SI. `terms` at
    speeds (n_speed,): what acts per unit of each, (n_coefficient, n_speed, 2) N, or where it follows the motion the stiffness,
    (n_coefficient, n_speed, 2, 2) N/m."""

    key: str
    name: str
    coefficients: tuple[tuple[str, str, float], ...]
    terms: Callable[[Array], ComplexArray]
    follows_motion: bool


def _rotating(power: int) -> Callable[[Array], ComplexArray]:
    """A vector fixed in the rotor, with its parts at angle 0 and a quarter turn on, that grows with a power of speed."""
    return lambda speed: np.array([1, 1j])[:, None, None] * speed[:, None] ** power * FORWARD


def _stiffness(matrices: Array, factor: complex, power: int) -> Callable[[Array], ComplexArray]:
    return lambda speed: matrices[:, None] * (factor * speed**power)[:, None, None]


def _pair(name: str, unit: str, size: float) -> tuple[tuple[str, str, float], ...]:
    return tuple((f"{name}_{axis}", unit, size) for axis in DIRECTIONS)


def _together(*parts: Callable[[Array], ComplexArray]) -> Callable[[Array], ComplexArray]:
    return lambda speed: np.concatenate([part(speed) for part in parts])


SPRING, OF_SPRING = _pair("k", "MN/m", 1e6), _stiffness(AXES, 1, 0)
DAMPER, OF_DAMPER = _pair("c", "kN s/m", 1e3), _stiffness(AXES, 1j, 1)
MASS, OF_MASS = (("m", "kg", 1.0),), _stiffness(np.eye(2)[None], -1, 2)

_ALL = (
    Law("constant", "constant, turning with the shaft", _pair("f", "N", 1.0), _rotating(0), False),
    Law("proportional_to_speed", "∝ Ω, turning with the shaft", _pair("f/Ω", "N s/rad", 1.0), _rotating(1), False),
    Law("unbalance", "unbalance, ∝ Ω²", _pair("u", "g mm", GRAM_MILLIMETRE), _rotating(2), False),
    Law("spring", "spring", SPRING, OF_SPRING, True),
    Law("damper", "damper", DAMPER, OF_DAMPER, True),
    Law("mass", "mass", MASS, OF_MASS, True),
    Law("cross_coupling", "cross-coupling", (("k_xy", "MN/m", 1e6),), _stiffness(CROSS, 1, 0), True),
    Law("spring_and_damper", "spring and damper", (*SPRING, *DAMPER), _together(OF_SPRING, OF_DAMPER), True),
    Law(
        "spring_damper_and_mass",
        "spring, damper and mass",
        (*SPRING, *DAMPER, *MASS),
        _together(OF_SPRING, OF_DAMPER, OF_MASS),
        True,
    ),
)

LAWS = MappingProxyType({law.key: law for law in _ALL})


def force_of(
    law: Law, coefficients: Array, speed: Array, motion: ComplexArray, per_force: ComplexArray
) -> ComplexArray:
    """What acts, (n, n_speed, 2) N, with coefficients (n, n_coefficient) SI at speeds (n_speed,), where the site moves by
    `motion` (n, n_speed, 2) m without it and by `per_force` (n, n_speed, 2, 2) m/N with each unit of it. A law that does not
    follow the motion asks for neither.

    Raises LinAlgError where there is no steady motion."""
    acting = np.einsum("nc,c...->n...", coefficients, law.terms(speed))
    if not law.follows_motion:
        return np.asarray(acting)
    return np.asarray(
        -np.linalg.solve(np.eye(len(DIRECTIONS)) + acting @ per_force, acting @ motion[..., None])[..., 0]
    )
