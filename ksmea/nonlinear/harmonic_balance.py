"""Harmonic balance: steady-state motion of sites of the shaft under nonlinear forces.

The forces depend on the motion.

The motion is u(φ) = Re Σ q_h e^{ihφ} over harmonics h of the rotation, φ = Ωt. Without the force its harmonics are Q_h, and each
unit of a force at hΩ moves the sites by G_h, so that

    q_h = Q_h + G_h f_h(q),      f_h = (1/π) ∫ F(u(φ), φ) e^{−ihφ} dφ    (1/2π for h = 0)

over a turn. The force is taken at angles of the orbit, and its harmonics and their derivatives are sums over these (alternating
frequency–time: T. M. Cameron and J. H. Griffin, J. Appl. Mech. 56 (1989) 149–154; T. Detroux, L. Renson, L. Masset and
G. Kerschen, Comput. Methods Appl. Mech. Eng. 296 (2015) 18–38, doi 10.1016/j.cma.2015.07.017). All is real here: the components of
a motion are the real and imaginary parts of its harmonics.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices, Mask
from ksmea.nonlinear.contact import OrbitForce

N_ANGLE = 128  # of a turn: corners of a contact force are worth 3e-3 of it
PER_HARMONIC = 8  # of the highest harmonic, angles in its period: more than 4 make sums of a cubic force exact
MAX_ITERATIONS = 25
CONVERGED = 1e-11  # of the motion: a few roundings
SHORTEST = 2.0**-6  # part of a Newton step


@dataclass(frozen=True)
class Harmonics:
    """Orders of the rotation that a motion has.

    If all are odd, half a turn determines the motion: forces on opposite points of such an orbit are opposite.
    """

    orders: tuple[int, ...] = (1,)
    n_angle: int = N_ANGLE  # of a turn, if the highest order has enough of them

    @cached_property
    def angles(self) -> Array:
        n = max(self.n_angle, PER_HARMONIC * max(self.orders))
        turn = 2 * np.pi * (np.arange(n) + 0.5) / n
        return turn[: n // 2] if all(order % 2 for order in self.orders) else turn

    @cached_property
    def turn(self) -> ComplexArray:
        """e^{iφ} at these."""
        return np.asarray(np.exp(1j * self.angles))

    @cached_property
    def parts(self) -> list[tuple[int, int]]:
        """The components: number of the order, and 0 for the real part or 1 for the imaginary one.

        Order 0 has one component.
        """
        return [(index, part) for index, order in enumerate(self.orders) for part in range(2 if order else 1)]

    @cached_property
    def basis(self) -> Array:
        """Basis functions of the components along the orbit, (n_component, n_angle)."""
        return np.stack([(1j**part * np.exp(1j * self.orders[index] * self.angles)).real for index, part in self.parts])

    @cached_property
    def weighted(self) -> Array:
        """By which components are means over the orbit, (n_component, n_angle)."""
        twice = np.array([2.0 if self.orders[index] else 1.0 for index, _ in self.parts])
        return twice[:, None] * self.basis / len(self.angles)

    @cached_property
    def products(self) -> Array:
        """Products of each two basis functions, (n_component², n_angle)."""
        return np.reshape(self.weighted[:, None] * self.basis, (-1, len(self.angles)))

    def components(self, motion: ComplexArray) -> Array:
        """Components of harmonics (n, n_order, m): (n, n_component m)."""
        rows = [motion[:, index].imag if part else motion[:, index].real for index, part in self.parts]
        return np.concatenate(rows, axis=-1)

    def motion(self, components: Array) -> ComplexArray:
        """The harmonics (n, n_order, m) of components (n, n_component m)."""
        n, p = components.shape
        rows = components.reshape(n, len(self.parts), p // len(self.parts))
        found = np.zeros((n, len(self.orders), rows.shape[-1]), dtype=complex)
        for row, (index, part) in enumerate(self.parts):
            found[:, index] += 1j**part * rows[:, row]
        return found

    def receptance(self, per_force: ComplexArray) -> Array:
        """Components of receptances (n, n_order, m, m): (n, n_component m, n_component m)."""
        n, _, m, _ = per_force.shape
        found = np.zeros((n, len(self.parts), m, len(self.parts), m))
        for row, (index, part) in enumerate(self.parts):
            for column, (other, of_force) in enumerate(self.parts):
                if index == other:
                    found[:, row, :, column] = (per_force[:, index] * 1j ** (of_force - part)).real
        return found.reshape(n, len(self.parts) * m, len(self.parts) * m)


@dataclass(frozen=True, eq=False)
class Balance:
    """The equations y = s Q + G f(y) at n points, each a speed and a set of values.

    The level s is 1 but on a way there.
    """

    force: OrbitForce
    coefficients: Array  # (n, n_coefficient)
    harmonics: Harmonics
    alone: Array  # Q (n, p), m, in components
    per_force: Array  # G (n, p, p), m/N
    rounding: float = 0.0  # of the force's corners

    def __getitem__(self, chosen: Indices) -> Balance:
        return dataclasses.replace(
            self,
            coefficients=self.coefficients[chosen],
            alone=self.alone[chosen],
            per_force=self.per_force[chosen],
        )

    def acting(self, motion: Array) -> tuple[Array, Array]:
        """Components f (n, p), N, of the force on a motion (n, p), m, and their derivatives (n, p, p), N/m."""
        of, n_part = self.harmonics, len(self.harmonics.parts)
        n, p = motion.shape
        m = p // n_part
        force, derivative = self.force(
            self.coefficients, of.basis.T @ motion.reshape(n, n_part, m), of.turn, self.rounding
        )
        by_motion = of.products @ derivative.reshape(n, len(of.angles), m * m)
        by_motion = by_motion.reshape(n, n_part, n_part, m, m).transpose(0, 1, 3, 2, 4)
        return (of.weighted @ force).reshape(n, p), by_motion.reshape(n, p, p)

    def left(self, motion: Array, level: Array) -> tuple[Array, Array]:
        """y − s Q − G f(y) of motions (n, p) at levels (n,), and its derivatives by y (n, p, p)."""
        force, derivative = self.acting(motion)
        left = motion - level[:, None] * self.alone - (self.per_force @ force[..., None])[..., 0]
        return left, np.eye(motion.shape[1]) - self.per_force @ derivative


def solved(balance: Balance, start: Array) -> tuple[Array, Mask]:
    """Motions (n, p) by Newton's method from a start, and where they solve the equations.

    Steps are halved until they leave less.
    """
    found, active = np.array(start), np.arange(len(start))
    is_found: Mask = np.zeros(len(start), dtype=bool)
    left, derivative = balance.left(found, np.ones(len(start)))
    size = np.linalg.norm(left, axis=1)
    for _ in range(MAX_ITERATIONS):
        is_found[active] = size[active] <= CONVERGED * np.linalg.norm(found[active], axis=1)
        active = active[~is_found[active]]
        if not len(active):
            break
        waiting, part = active, 1.0
        step = np.linalg.solve(derivative[active], -left[active, :, None])[..., 0]
        while len(waiting):
            trial = found[waiting] + part * step
            rest, slope = balance[waiting].left(trial, np.ones(len(waiting)))
            rest_size = np.linalg.norm(rest, axis=1)
            is_lower = (rest_size < size[waiting]) | (part < SHORTEST)
            at = waiting[is_lower]
            found[at], left[at], derivative[at], size[at] = (each[is_lower] for each in (trial, rest, slope, rest_size))
            waiting, step, part = waiting[~is_lower], step[~is_lower], part / 2
    return found, is_found


def left_out(balance: Balance, motion: Array) -> Array:
    """Ratio (n,) of the largest harmonic of the force left out by the motion (n, p) to the first one.

    Harmonics up to twice the highest of the motion count. The ratio estimates the error, as receptances fall with the
    square of the order above all resonances.
    """
    own = balance.harmonics
    step = 2 if all(order % 2 for order in own.orders) else 1
    further = tuple(range(max(own.orders) + step, 2 * max(own.orders) + step + 1, step))
    wider = Harmonics((*own.orders, *further), own.n_angle)
    n_more = len(wider.parts) - len(own.parts)
    m = motion.shape[1] // len(own.parts)
    held = np.pad(motion, [(0, 0), (0, n_more * m)])
    force, _ = dataclasses.replace(balance, harmonics=wider).acting(held)
    size = np.linalg.norm(wider.motion(force), axis=-1)  # (n, n_order)
    first = size[:, 0]
    return np.asarray(size[:, len(own.orders) :].max(axis=1) / np.where(first, first, 1.0))
