"""How fast free motions of a rotor grow at a spin speed, from its damped eigenvalues.

A free motion is Re(q e^{λt}), λ = σ + iω, and the rotor is stable where every σ is below zero. The spin speed Ω and the
whirl frequency ω are kept apart: at each Ω all ω matter. Bearings act as K(Ω) + λ C(Ω), their coefficients being functions
of the spin speed; supports are functions of λ and have degrees of freedom of their own (`problems/rotor/free_motion/support.py`).

The rotor is seen in the space of its lowest modes and of its deflections under forces at the bearings, which leaves out
only what lies far above the spin speed: free motions that grow whirl below it, or little above. With supports, e_l the
deflections of support l and d = q_b − Σ T_l e_l those of the bearings (T_l takes a common support to each, else it is 1),

    λ² q + λ (C + ΩG) q + (K + ΩN) q + Pᵀ (K_b + λ C_b) d = 0,      (1 + iη_l) e_l + λ² s_l m_l e_l − s_l T_lᵀ (K_b + λ C_b) d = 0,

which also holds for s_l = 0 and m_l = 0, where eigenvalues go to infinity and are left out. A loss factor is that of
motions with ω > 0: the other half of the plane is no motion of the rotor.

M. I. Friswell, J. E. T. Penny, S. D. Garvey & A. W. Lees, Dynamics of Rotating Machines, 2010, chapters 5 and 7.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.linalg

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import DIRECTIONS
from problems.rotor.finite_elements.assembly import Matrices, assemble_free, displacement_row, node_dof
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.free_motion.support import Support

REACH = 4.0  # modes up to this many times the highest speed
HEADROOM = 1.5  # of a problem's highest speed
MIN_MODES = 12
WEAKEST = 1e-3  # of the stiffest bearing: springs of the rotor whose modes these are, where a bearing has less
SAME_DIRECTION = 1e-5  # relative: what differs by less from the modes is left out, there is rounding in it
NEITHER = 1e-7  # |σ|/|λ| up to which a motion counts as neither growing nor decaying: rounding
INFINITE = 1e4  # times the highest frequency: eigenvalues beyond it are those of supports without compliance or mass


@dataclass(frozen=True, eq=False)
class LowModes:
    """A rotor without bearings in the space of its lowest modes; its own mass matrix is the unit matrix."""

    matrices: (
        Matrices  # (n_low, n_low) each; damping and stiffness (n_speed, n_low, n_low) where what is attached has them
    )
    ports: Array  # (n_port, n_low), the deflections at the bearings
    sites: Array  # (2 n_site, n_low), those in x and y at further positions
    basis: Array  # (n_dof, n_low), those of the whole rotor
    highest: float  # rad/s, up to which the modes reach

    def with_attached(self, site: int, mass: Array, damping: Array, stiffness: Array) -> LowModes:
        """The same rotor with a mass (2, 2), damper and spring (n_speed, 2, 2) at one of its sites."""
        own, rows = self.matrices, self.sites[2 * site : 2 * site + 2]
        mass, damping, stiffness = (rows.T @ each @ rows for each in (mass, damping, stiffness))
        changed = dataclasses.replace(
            own, mass=own.mass + mass, damping=own.damping + damping, stiffness=own.stiffness + stiffness
        )
        return dataclasses.replace(self, matrices=changed)


@lru_cache(maxsize=64)
def low_modes(rotor: Rotor, highest: float, positions: tuple[float, ...] = (), least: int = MIN_MODES) -> LowModes:
    """The rotor on springs about as stiff as its bearings: modes up to `REACH` times a speed (rad/s), `least` or more, and its
    deflections under forces at the bearings and at further positions (m)."""
    free = assemble_free(rotor)
    dof = np.concatenate([node_dof(rotor.node_at(bearing.position, "bearing"))[:2] for bearing in rotor.bearings])
    stiffness = free.stiffness.copy()
    stiffness[dof, dof] += nominal_springs(rotor)
    squared, shapes = scipy.linalg.eigh(stiffness, free.mass)
    n_mode = max(least, int(np.count_nonzero(squared <= (REACH * highest) ** 2)))
    rows = [displacement_row(rotor, position, axis) for position in positions for axis in DIRECTIONS]
    forces = np.column_stack([np.eye(len(stiffness))[:, dof], *rows])
    # the highest speed stands in for a spring where nothing holds the rotor
    deflections = np.linalg.solve(stiffness + highest**2 * free.mass, forces)
    basis = np.hstack([shapes[:, :n_mode], deflections])
    basis = basis / np.sqrt(np.einsum("ij,ij->j", basis, free.mass @ basis))
    sizes, directions = np.linalg.eigh(basis.T @ free.mass @ basis)
    kept = sizes > SAME_DIRECTION**2 * sizes[-1]
    basis = basis @ (directions[:, kept] / np.sqrt(sizes[kept]))
    basis = basis @ np.linalg.eigh(basis.T @ stiffness @ basis)[1]  # rounding of high modes stays away from low ones
    parts = (free.damping, free.gyroscopic, free.stiffness, free.circulatory)
    matrices = Matrices(np.eye(basis.shape[1]), *(basis.T @ part @ basis for part in parts))
    sites = np.reshape(rows, (-1, len(basis))) @ basis
    return LowModes(matrices, basis[dof], sites, basis, REACH * highest)


def nominal_springs(rotor: Rotor) -> Array:
    """Springs at the ports about as stiff as the bearings, (n_port,) N/m."""
    springs = np.abs(np.concatenate([np.diag(bearing.stiffness) for bearing in rotor.bearings]))
    return np.maximum(springs, WEAKEST * np.max(springs))


def searched_speed(own: Array, asked: Array) -> float:
    """The speed (rad/s) that the modes must suit: the same for all that is asked of a problem a little above its own."""
    return float(max(HEADROOM * np.max(own), np.max(asked)))


def growth_rate(
    low: LowModes, speed: Array, stiffness: Array, damping: Array, supports: Sequence[Support] = ()
) -> Array:
    """The largest real part of any eigenvalue of these modes, (n_speed,) 1/s, at spin speeds (n_speed,) rad/s; 0 where a motion neither
    grows nor decays.

    `stiffness` and `damping` of the bearings are (n_speed, n_bearing, 2, 2) N/m and N s/m, `supports` those of one
    parameter set, from the bearing to the ground.
    """
    spin = speed[:, None, None]
    own_damping = low.matrices.damping + spin * low.matrices.gyroscopic
    own_stiffness = low.matrices.stiffness + spin * low.matrices.circulatory
    bearing_stiffness, bearing_damping = by_port(stiffness), by_port(damping)
    if not supports:
        own_stiffness = own_stiffness + low.ports.T @ bearing_stiffness @ low.ports
        own_damping = own_damping + low.ports.T @ bearing_damping @ low.ports
        parts = np.linalg.solve(low.matrices.mass, np.stack([own_stiffness, own_damping]))
        return _largest(np.linalg.eigvals(state_matrices(*parts)).astype(complex))
    return np.array(
        [
            _largest(_on_supports(low, *parts, supports)[None])[0]
            for parts in zip(own_stiffness, own_damping, bearing_stiffness, bearing_damping)
        ]
    )


def _on_supports(
    low: LowModes, stiffness: Array, damping: Array, of_bearings: Array, damping_of_bearings: Array,
    supports: Sequence[Support],
) -> ComplexArray:  # fmt: skip
    """Eigenvalues (n,) at one spin speed, 0 in place of infinite ones."""
    pencil = pencil_on_supports(low, stiffness, damping, of_bearings, damping_of_bearings, supports)
    return finite_eigenvalues(*scipy.linalg.eigvals(*pencil, homogeneous_eigvals=True)) * low.highest


def pencil_on_supports(
    low: LowModes, stiffness: Array, damping: Array, of_bearings: Array, damping_of_bearings: Array,
    supports: Sequence[Support],
) -> tuple[ComplexArray, Array]:  # fmt: skip
    """A and B (2n, 2n) of A z = λ B z with z = (q, e, λq, λe) at one spin speed; time in units of the highest frequency."""
    n_port, n_low = low.ports.shape
    n_bearing = n_port // 2
    carries = [np.tile(np.eye(2), (n_bearing, 1)) if support.is_common else np.eye(n_port) for support in supports]
    bearing = np.hstack([low.ports, *(-each for each in carries)])  # d = bearing @ (q, e)
    springs = [np.diag(np.tile(one.spring[:, 0], each.shape[1] // 2)) for one, each in zip(supports, carries)]
    forces = np.vstack([low.ports.T, *(-spring @ each.T for spring, each in zip(springs, carries))])
    elastic = [(1 + 1j * support.loss_factor) * np.eye(len(spring)) for support, spring in zip(supports, springs)]
    inertia = [support.mass[0] * low.highest**2 * spring for support, spring in zip(supports, springs)]
    unit = low.highest**2  # the rotor's rows in terms of it
    scale = np.ones(len(forces))
    scale[:n_low] = 1 / unit
    none = np.zeros((sum(map(len, springs)),) * 2)
    of_stiffness = scipy.linalg.block_diag(stiffness / unit, *elastic) + scale[:, None] * forces @ of_bearings @ bearing
    of_damping = low.highest * (
        scipy.linalg.block_diag(damping / unit, none) + scale[:, None] * forces @ damping_of_bearings @ bearing
    )
    mass = scipy.linalg.block_diag(low.matrices.mass, *inertia)
    n = len(mass)
    left = np.block([[np.zeros((n, n)), np.eye(n)], [-of_stiffness, -of_damping]])
    right = scipy.linalg.block_diag(np.eye(n), mass)
    return left, right


def finite_eigenvalues(numerator: ComplexArray, denominator: ComplexArray) -> ComplexArray:
    """Eigenvalues (n,) as quotients, 0 in place of infinite ones."""
    finite = np.abs(numerator) < INFINITE * np.abs(denominator)
    return np.asarray(np.divide(numerator, denominator, out=np.zeros_like(numerator), where=finite))


def _largest(eigenvalues: ComplexArray) -> Array:
    """The largest real part of eigenvalues (…, n) of motions that whirl with ω ≥ 0, or hardly whirl at all."""
    real, size = eigenvalues.real, np.abs(eigenvalues)
    real = np.where(np.abs(real) > NEITHER * size, real, 0.0)
    is_motion = (eigenvalues.imag > -np.abs(real)) & (size > 0)
    return np.asarray(np.max(np.where(is_motion, real, -np.inf), axis=-1))


def by_port(parts: Array) -> Array:
    """Matrices of the bearings (n_speed, n_bearing, 2, 2) as one of all ports (n_speed, n_port, n_port)."""
    n_speed, n_bearing = parts.shape[:2]
    whole = np.zeros((n_speed, n_bearing, 2, n_bearing, 2))
    for bearing in range(n_bearing):
        whole[:, bearing, :, bearing] = parts[:, bearing]
    return whole.reshape(n_speed, 2 * n_bearing, 2 * n_bearing)


def state_matrices(stiffness: Array, damping: Array) -> Array:
    """A of ż = A z with z = (q, q̇) and a unit mass matrix, (n_speed, 2 n_low, 2 n_low)."""
    n_speed, n = stiffness.shape[:2]
    top = np.broadcast_to(np.hstack([np.zeros((n, n)), np.eye(n)]), (n_speed, n, 2 * n))
    return np.concatenate([top, np.concatenate([-stiffness, -damping], axis=2)], axis=1)
