"""How fast free motions of a rotor grow at a spin speed, from its damped eigenvalues.

A free motion is Re(q e^{λt}), λ = σ + iω, and the rotor is stable where every σ is below zero. The spin speed Ω and the
whirl frequency ω are kept apart: at each Ω all ω matter. Bearings act as K(Ω) + λ C(Ω), their coefficients being functions
of the spin speed; supports are functions of λ and have degrees of freedom of their own (`problems/rotor/finite_elements/bearing.py`).

The rotor is seen in the space of its lowest modes and of its deflections under forces at the bearings, which leaves out
only what lies far above the spin speed: free motions that grow whirl below it, or little above. With supports, e_l the
deflections of support l, v of the housings on pedestals of the rotor itself, and d = q_b − v − Σ T_l e_l of the bearings
(T_l takes a common support to each, else it is 1), and with f = (K_b + λ C_b + λ² M_b) d,

    λ² q + λ (C + ΩG) q + (K + ΩN) q + Pᵀ f = 0,   (1 + iη_l) e_l + λ² s_l m_l e_l − s_l T_lᵀ f = 0,   (K_p + λ C_p + λ² M_p) v − f = 0,

which also holds for s_l = 0 and m_l = 0, where eigenvalues go to infinity and are left out. A loss factor holds for
motions with ω > 0: the other half of the plane has no motion of the rotor.

M. I. Friswell, J. E. T. Penny, S. D. Garvey & A. W. Lees, Dynamics of Rotating Machines, 2010, chapters 5 and 7.

Rotors that nothing feeds energy to are stable at every speed, which spares the eigenvalues of most of them. A free motion q e^{λt}, λ = σ + iω, of M, C, G, K with all that is attached leaves λ*(λ²M + λ(C + ΩG) + K + iH) q = 0 along q*,
H the hysteretic part of supports. If K is symmetric and the circulatory matrix is zero, the real part is

    σ (|λ|² m + k) = −(|λ|² c + ω h),      m, c, k, h the values of q*Mq, q*(C + Cᵀ)q/2, q*Kq and q*Hq,

in which gyroscopic matrices do no work. With c ≥ 0, k ≥ 0 and m > 0 no motion of ω ≥ 0 grows (Kelvin, Tait and Chetaev; F. Ziegler,
Principles of Structural Stability, 1968, section 3.4). Nor does one that hardly whirls, |ω| < |σ|, with loss factors below 1: h < k.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.measurement.channel import DIRECTIONS
from problems.rotor.finite_elements.assembly import Matrices, assemble_free, displacement_row, node_dof
from problems.rotor.finite_elements.bearing import (
    COEFFICIENTS,
    DAMPINGS,
    Bearing,
    Pedestal,
    Support,
    numbers_of,
    with_coefficients,
)
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import ShaftSegment

REACH = 4.0  # modes up to this many times the highest speed
HEADROOM = 1.5  # of a problem's highest speed
MIN_MODES = 12
IS_DAMPING = np.isin(COEFFICIENTS, DAMPINGS)
Pencil = tuple[ComplexArray, Array]  # A and B of A z = λ B z
WEAKEST = 1e-3  # of the stiffest bearing: springs of the rotor whose modes these are, where a bearing has less
SAME_DIRECTION = 1e-5  # relative: what differs by less from the modes is left out, there is rounding in it
NEITHER = 1e-7  # |σ|/|λ| up to which a motion counts as neither growing nor decaying: rounding
SLOWEST = 1e-6  # of the highest frequency: slower motions are at rest but for rounding, and do not grow
AT_REST = 1e-7  # of the middle one of all frequencies: slower motions are those of a rotor that nothing holds
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
        """Rotor with a mass (2, 2), damper and spring (n_speed, 2, 2) at one of its sites."""
        own, rows = self.matrices, self.sites[2 * site : 2 * site + 2]
        mass, damping, stiffness = (rows.T @ each @ rows for each in (mass, damping, stiffness))
        changed = dataclasses.replace(
            own, mass=own.mass + mass, damping=own.damping + damping, stiffness=own.stiffness + stiffness
        )
        return dataclasses.replace(self, matrices=changed)


@lru_cache(maxsize=64)
def low_modes(rotor: Rotor, highest: float, positions: tuple[float, ...] = (), least: int = MIN_MODES) -> LowModes:
    """The rotor on springs about as stiff as its bearings.

    Modes up to `REACH` times a speed (rad/s), `least` or more, and its deflections under forces at the bearings and at
    further positions (m).
    """
    free = assemble_free(rotor).below_spin()
    dof = ports_of(rotor, rotor.supported)
    stiffness = free.stiffness.copy()
    np.add.at(stiffness, (dof, dof), nominal_springs(rotor.supported))
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


def nominal_springs(bearings: Sequence[Bearing]) -> Array:
    """Springs at the ports about as stiff as the bearings, (n_port,) N/m.

    They are taken at the first speed of their tables.
    """
    if not bearings:
        return np.zeros(0)
    springs = np.abs(np.concatenate([np.diag(_first_stiffness(bearing)) for bearing in bearings]))
    return np.maximum(springs, WEAKEST * np.max(springs))


def _first_stiffness(bearing: Bearing) -> Array:
    return bearing.stiffness if bearing.table is None else bearing.matrices_at(np.array(bearing.table.speed[:1]))[0][0]


def ports_of(rotor: Rotor, bearings: Sequence[Bearing]) -> Indices:
    """Degrees of freedom of the shaft in x and y at each of these bearings, (n_port,)."""
    dof = [node_dof(rotor.node_at(bearing.position, "bearing"))[:2] for bearing in bearings]
    return np.concatenate([np.empty(0, dtype=int), *dof])


def searched_speed(own: Array, asked: Array) -> float:
    """The speed (rad/s) that the modes must suit.

    It is common to all requests to a problem a little above its own.
    """
    return float(max(HEADROOM * np.max(own), np.max(asked)))


@dataclass(frozen=True, eq=False)
class Held:
    """Supports of a rotor at n_speed spin speeds.

    Matrices of bearings and seals (n_speed, n_supported, 2, 2) N/m, N s/m, kg, the supports of effects for one
    parameter set, from the bearing to the ground, and the pedestals of bearings by their index.
    """

    speed: Array
    stiffness: Array
    damping: Array
    mass: Array
    supports: tuple[Support, ...] = ()
    pedestals: tuple[tuple[int, Pedestal], ...] = ()

    @property
    def is_on_ground(self) -> bool:
        return not self.supports and not self.pedestals

    def at_ports(self) -> tuple[Array, Array, Array]:
        """K, C, M between all ports, (n_speed, n_port, n_port)."""
        return by_port(self.stiffness), by_port(self.damping), by_port(self.mass)

    def with_damping(self, part: float) -> Held:
        """With a part of all damping, and of the part of stiffness that is not symmetric."""
        return dataclasses.replace(
            self,
            stiffness=towards_symmetric(self.stiffness, part),
            damping=part * self.damping,
            supports=tuple(dataclasses.replace(each, loss_factor=part * each.loss_factor) for each in self.supports),
            pedestals=tuple((index, _less_damped(each, part)) for index, each in self.pedestals),
        )


def towards_symmetric(matrices: Array, part: float) -> Array:
    """The symmetric part of matrices, and a part of the rest."""
    transposed = np.swapaxes(matrices, -1, -2)
    return (matrices + transposed) / 2 + part * (matrices - transposed) / 2


def _less_damped(pedestal: Pedestal, part: float) -> Pedestal:
    stiffness = towards_symmetric(np.array(numbers_of(pedestal)[:4]).reshape(2, 2), part).ravel()
    others = np.where(IS_DAMPING, part, 1.0)[4:] * numbers_of(pedestal)[4:]
    changed = with_coefficients(pedestal, np.concatenate([stiffness, others]))
    return dataclasses.replace(changed, loss_factor=part * pedestal.loss_factor)


def growth_rate(low: LowModes, held: Held) -> Array:
    """The largest real part of any eigenvalue of these modes, (n_speed,) 1/s, at each spin speed.

    It is 0 if a motion neither grows nor decays.
    """
    pencils = pencils_of(low, held)
    if not isinstance(pencils, list):
        return _largest(np.linalg.eigvals(pencils).astype(complex), low.highest)
    found = [finite_eigenvalues(*scipy.linalg.eigvals(*each, homogeneous_eigvals=True)) for each in pencils]
    return np.array([_largest(each[None] * low.highest, low.highest)[0] for each in found])


def pencils_of(low: LowModes, held: Held) -> Array | list[Pencil]:
    """State matrices (n_speed, 2 n_low, 2 n_low) of a rotor on rigid ground.

    A rotor on supports has two matrices for each speed.
    """
    own, spin = low.matrices, held.speed[:, None, None]
    stiffness, damping = own.stiffness + spin * own.circulatory, own.damping + spin * own.gyroscopic
    springs, dampers, masses = held.at_ports()
    if not held.is_on_ground:
        parts = zip(held.speed, stiffness, damping, springs, dampers, masses)
        return [_pencil_on_supports(low, float(speed), each, held) for speed, *each in parts]
    mass = own.mass + low.ports.T @ masses @ low.ports if np.any(masses) else own.mass
    stiffness = stiffness + low.ports.T @ springs @ low.ports
    damping = damping + low.ports.T @ dampers @ low.ports
    return state_matrices(*np.linalg.solve(mass, np.stack([stiffness, damping])))


def _pencil_on_supports(low: LowModes, speed: float, matrices: Sequence[Array], held: Held) -> Pencil:
    """A and B (2n, 2n) of A z = λ B z with z = (q, e, v, λq, λe, λv) at one spin speed.

    Time in units of the highest frequency. The matrices are stiffness and damping (n_low, n_low) of the rotor, then K,
    C, M (n_port, n_port) of its bearings.
    """
    stiffness, damping, *of_bearings = matrices
    n_port = len(low.ports)
    supports, unit = held.supports, low.highest**2  # the rows of rotor and housings in terms of it
    carries = [np.tile(np.eye(2), (n_port // 2, 1)) if support.is_common else np.eye(n_port) for support in supports]
    springs = [np.diag(np.tile(one.spring[:, 0], each.shape[1] // 2)) for one, each in zip(supports, carries)]
    housings = [np.eye(n_port)[:, 2 * index : 2 * index + 2] for index, _ in held.pedestals]
    bearing = np.hstack([low.ports, *(-each for each in (*carries, *housings))])  # d = bearing @ (q, e, v)
    forces = np.vstack(
        [
            low.ports.T / unit,
            *(-spring @ each.T for spring, each in zip(springs, carries)),
            *(-each.T / unit for each in housings),
        ]
    )
    own = [pedestal.matrices(speed) for _, pedestal in held.pedestals]
    elastic = [(1 + 1j * support.loss_factor) * np.eye(len(spring)) for support, spring in zip(supports, springs)]
    inertia = [support.mass[0] * unit * spring for support, spring in zip(supports, springs)]
    none = np.zeros((sum(map(len, springs)),) * 2)
    on_bearings = [forces @ each @ bearing for each in of_bearings]
    block = scipy.linalg.block_diag
    of_stiffness = block(stiffness / unit, *elastic, *(each[0] / unit for each in own)) + on_bearings[0]
    of_damping = low.highest * (block(damping / unit, none, *(each[1] / unit for each in own)) + on_bearings[1])
    mass = block(low.matrices.mass, *inertia, *(each[2] for each in own)) + unit * on_bearings[2]
    n = len(mass)
    left = np.block([[np.zeros((n, n)), np.eye(n)], [-of_stiffness, -of_damping]])
    return left, block(np.eye(n), mass)


def finite_eigenvalues(numerator: ComplexArray, denominator: ComplexArray) -> ComplexArray:
    """Eigenvalues (n,) as quotients, 0 in place of infinite ones."""
    finite = np.abs(numerator) < INFINITE * np.abs(denominator)
    return np.asarray(np.divide(numerator, denominator, out=np.zeros_like(numerator), where=finite))


def _largest(eigenvalues: ComplexArray, highest: float) -> Array:
    """Largest real part of eigenvalues (…, n) of motions that whirl with ω ≥ 0, or hardly at all."""
    real, size = eigenvalues.real, np.abs(eigenvalues)
    real = np.where(np.abs(real) > NEITHER * size, real, 0.0)
    is_motion = (eigenvalues.imag > -np.abs(real)) & (size > SLOWEST * highest)
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


def is_passive(
    rotor: Rotor,
    springs: Iterable[Array],
    dampers: Iterable[Array],
    masses: Iterable[Array],
    supports: Sequence[Support] = (),
) -> bool:
    """Whether nothing of a rotor can feed a free vibration at any of the speeds.

    Springs N/m, dampers N s/m and masses kg are given at these, (…, 2, 2) each; its own bearings are not considered.
    """
    shaft = [segment for segment in rotor.segments if isinstance(segment, ShaftSegment)]
    shaft_takes_energy = (
        rotor.internal_damping == 0
        and all(segment.internal_damping == 0 and segment.loss_factor == 0 for segment in shaft)
        and all(rotor.axial_force + segment.axial_force >= 0 for segment in shaft)
    )
    supports_take_energy = all(
        np.all(each.spring >= 0) and np.all(each.mass >= 0) and 0 <= each.loss_factor < 1 for each in supports
    )
    return bool(
        shaft_takes_energy
        and supports_take_energy
        and all(_is_symmetric(each) and _dissipates(each) for each in (*springs, *masses))
        and all(_dissipates(each) for each in dampers)
    )


def _is_symmetric(matrices: Array) -> bool:
    return bool(np.all(matrices[..., 0, 1] == matrices[..., 1, 0]))


def _dissipates(matrices: Array) -> bool:
    """Whether the symmetric parts of matrices (…, 2, 2) have no negative eigenvalue."""
    one, other = matrices[..., 0, 0], matrices[..., 1, 1]
    beside = (matrices[..., 0, 1] + matrices[..., 1, 0]) / 2
    return bool(np.all(one >= 0) and np.all(other >= 0) and np.all(one * other >= beside**2))
