"""Steady motion of shaft sites under nonlinear forces, as reached by a slow run-up or coast-down.

If a resonance curve folds over, several steady motions exist. A spring that stiffens leans it to higher speeds: a
slow run-up stays on the large motion until that ends and falls, and on the way down the small one stays until that
ends. A spring that softens leans it to lower speeds, with both changed over (A. H. Nayfeh and D. T. Mook, Nonlinear
Oscillations, 1979, section 4.1). So a motion is chosen at each speed by itself: up on a stiffening force and down on
a softening one the largest stable motion, else the smallest. If resonances in two directions lean over each other, a
third stable motion may exist, on which a slow run may be: it is not detected.

The speeds with a single motion are known beforehand. With Z = G⁻¹, a force that stiffens is monotone, and so are the
equations if Z + Zᴴ is positive definite; for one that softens, if it is negative definite. Dissipation bounds all
motions, by |ZQ| / λ_min((Z − Zᴴ)/2i), and so the derivative of the force; if that is small against Z, the motion is
unique too. At other speeds all are found with the frequency of rotation alone (`ksmea.nonlinear.branches`), and the
chosen one leads to the motion with all harmonics.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices, Mask
from ksmea.nonlinear.branches import Branches, branches
from ksmea.nonlinear.contact import OrbitForce
from ksmea.nonlinear.harmonic_balance import N_ANGLE, Balance, Harmonics, left_out, solved
from ksmea.nonlinear.slow_run import most_held, n_held, n_negative

CONTRACTS = 0.5  # |G ∂f/∂y| below which there is one motion: derivatives vary around the orbit
ROUNDINGS = (0.5, 0.1, 0.0)  # of the corners of a force, from that which branches are followed by to none
REGULAR = 1e-9  # of the largest receptance: added to one that no force moves


@dataclass(frozen=True)
class SiteMotion:
    """Motion of sites at speeds (n_speed,), rad/s.

    It is given by Q (n, n_speed, m), m, at the frequency of rotation without a force on them, and by G (n, n_speed, m,
    m), m/N, with each unit of one. `further` has G at other harmonics, by their order. `near` (n, n_speed, n_known, m),
    m, has the first harmonics of a motion next to which the steady one is.
    """

    speed: Array
    without_force: ComplexArray
    per_force: ComplexArray
    near: ComplexArray | None = None
    further: Mapping[int, ComplexArray] = field(default_factory=dict)

    @property
    def orders(self) -> tuple[int, ...]:
        """Orders of the harmonics, the 1X first."""
        return (1, *self.further)


@dataclass(frozen=True)
class SteadyForce:
    """A force in the motion that it is part of: harmonics (n, n_speed, n_order, m) of both, N and m.

    `left_out` (n, n_speed) is the ratio of the largest neglected harmonic of the force to its harmonic of rotation."""

    harmonics: ComplexArray
    motion: ComplexArray
    left_out: Array


@dataclass(frozen=True)
class SiteForce:
    """Force on sites with n sets of coefficients (n, n_coefficient).

    It states which way it bends resonance curves, and which way the speed goes.
    """

    on_orbit: OrbitForce
    coefficients: Array
    stiffens: Array  # (n,): 1 it stiffens, −1 it softens, 0 it is linear in the motion; nan: some of it stiffens
    goes_up: bool = True
    has_corners: bool = True

    @property
    def stays_large(self) -> Mask:
        """Whether the largest stable motion is chosen, (n,)."""
        return np.asarray((self.stiffens < 0) != self.goes_up)


def steady_force(force: SiteForce, site: SiteMotion) -> SteadyForce:
    """Force in the steady motion. Raises LinAlgError if no steady motion is found."""
    n, n_speed, m = site.without_force.shape
    row = np.repeat(np.arange(n), n_speed)
    alone = site.without_force.reshape(-1, m)
    per_force = np.stack([each.reshape(-1, m, m) for each in (site.per_force, *site.further.values())], axis=1)
    at_rotation = per_force[:, 0]
    whole = _balance(
        force.on_orbit,
        force.coefficients[row],
        Harmonics(site.orders, N_ANGLE if force.has_corners else 0),
        alone,
        per_force,
    )
    rotation = _balance(
        force.on_orbit,
        force.coefficients[row],
        Harmonics((1,), N_ANGLE // 2 if force.has_corners else 0),
        alone,
        at_rotation[:, None],
    )
    stiffness = _dynamic_stiffness(at_rotation)
    largest = _largest(alone, stiffness)
    if site.near is None:
        start, plain = alone[:, None], _has_one_motion(rotation, stiffness, force.stiffens[row], largest)
    else:
        start, plain = site.near.reshape(len(alone), -1, m), np.ones(len(alone), dtype=bool)

    motion, is_found = np.empty_like(whole.alone), np.zeros(len(alone), dtype=bool)
    tried = np.flatnonzero(plain)
    motion[tried], is_found[tried] = solved(whole[tried], _components(start[tried], site.orders))
    # by the frequency of rotation alone; where that leads nowhere by all harmonics; where these do not settle, as roughly as that
    for guide, balance, roundings in (
        (rotation, whole, ROUNDINGS),
        (whole, whole, ROUNDINGS),
        (rotation, rotation, ROUNDINGS[:1]),
    ):
        known, lacking = np.flatnonzero(is_found), np.flatnonzero(~is_found)
        if not len(lacking):
            break
        stays_large = force.stays_large[row[lacking]]
        rounded = dataclasses.replace(guide[lacking], rounding=ROUNDINGS[0])
        found = branches(rounded, largest[lacking], ~stays_large)
        at = np.concatenate([known, lacking[found.point]])
        moved = np.concatenate([motion[known, : 2 * m], found.motion[:, : 2 * m]])
        held = n_held(rotation[at], stiffness[at], moved, force.stiffens[row[at]])
        is_stable = np.concatenate([np.ones(len(known), dtype=bool), found.is_stable])
        reach = most_held(site.speed, force.stiffens, n_negative(stiffness).reshape(n, n_speed), at, held, is_stable)
        is_reached = (held <= reach.ravel()[at])[len(known) :]
        size = np.linalg.norm(found.motion, axis=1)
        order = np.lexsort([np.where(stays_large[found.point], -size, size), ~is_reached, ~found.is_stable])
        moved, is_found[lacking] = _sharpened(balance[lacking], found, order, roundings)
        motion[lacking] = _padded(moved, whole)
    if not is_found.all():
        raise np.linalg.LinAlgError("no steady motion was found under this force")
    acting, moving = (
        whole.harmonics.motion(each).reshape(n, n_speed, -1, m) for each in (whole.acting(motion)[0], motion)
    )
    return SteadyForce(acting, moving, left_out(whole, motion).reshape(n, n_speed))


def _sharpened(balance: Balance, found: Branches, order: Indices, roundings: Sequence[float]) -> tuple[Array, Mask]:
    """Solutions (n, p) next to motions with rounded corners, and whether there is one.

    Each point has the solution that comes first in an order, or the next one if that leads to none.
    """
    motion, is_found = np.empty_like(balance.alone), np.zeros(len(balance.alone), dtype=bool)
    while len(order):
        chosen = order[np.unique(found.point[order], return_index=True)[1]]
        at = found.point[chosen]
        motion[at] = _padded(found.motion[chosen], balance)
        for rounding in roundings:
            motion[at], is_found[at] = solved(dataclasses.replace(balance[at], rounding=rounding), motion[at])
        order = order[~is_found[found.point[order]] & ~np.isin(order, chosen)]
    return motion, is_found


def _padded(motion: Array, whole: Balance) -> Array:
    """A motion in the components of the whole, whose first ones it has."""
    return np.pad(motion, [(0, 0), (0, whole.alone.shape[1] - motion.shape[1])])


def _balance(
    force: OrbitForce, coefficients: Array, harmonics: Harmonics, alone: ComplexArray, per_force: ComplexArray
) -> Balance:
    excited = _components(alone[:, None], harmonics.orders)
    return Balance(force, coefficients, harmonics, excited, harmonics.receptance(per_force))


def _components(first: ComplexArray, orders: tuple[int, ...]) -> Array:
    """Components of a motion that has only the first (n, n_known, m) of these harmonics."""
    motion = np.zeros((len(first), len(orders), first.shape[2]), dtype=complex)
    motion[:, : first.shape[1]] = first
    return Harmonics(orders).components(motion)


def _dynamic_stiffness(per_force: ComplexArray) -> ComplexArray:
    size = REGULAR * np.abs(per_force).max(axis=(1, 2), keepdims=True)
    return np.asarray(np.linalg.inv(per_force + np.where(size, size, 1.0) * np.eye(per_force.shape[1])))


def _largest(alone: ComplexArray, stiffness: ComplexArray) -> Array:
    """Largest possible motion under any force that feeds it nothing, (n,) m.

    Infinite where the rotor itself feeds it.
    """
    damping = np.linalg.eigvalsh((stiffness - stiffness.conj().swapaxes(1, 2)) / 2j)[:, 0]
    exciting = np.linalg.norm((stiffness @ alone[..., None])[..., 0], axis=1)
    return np.asarray(np.divide(exciting, damping, out=np.full(len(alone), np.inf), where=damping > 0))


def _has_one_motion(rotation: Balance, stiffness: ComplexArray, stiffens: Array, largest: Array) -> Mask:
    """Whether a single motion is certain, (n,)."""
    real = np.linalg.eigvalsh((stiffness + stiffness.conj().swapaxes(1, 2)) / 2)
    is_monotone = np.where(stiffens > 0, real[:, 0] > 0, real[:, -1] < 0) & ~np.isnan(stiffens)
    m = rotation.alone.shape[1] // 2
    line = np.tile(np.where(np.isfinite(largest), largest, 0.0)[:, None], (1, 2 * m))
    line[:, m:] = 0  # along the diagonal: each coordinate goes as far as all together may
    _, derivative = rotation.left(line, np.zeros(len(line)))
    change = np.linalg.norm(derivative - np.eye(2 * m), axis=(1, 2))
    at_rest = ~np.any(rotation.alone, axis=1)
    return np.asarray((stiffens == 0) | is_monotone | (np.isfinite(largest) & (change < CONTRACTS)) | at_rest)
