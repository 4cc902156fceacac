"""Free motions of a rotor with whatever its bearings and effects do, at many spin speeds.

The rotor is seen in the space of its lowest modes and of its deflections under forces at its ports, as for its stability
(`problems/rotor/free_motion/stability.py`); with `N_MODE` modes, frequencies up to the highest one requested are true within 1e-5.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from scipy.optimize import brentq

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import DIRECTIONS, Channel
from ksmea.rotordynamics.layout import EffectMark, RotorLayout
from ksmea.rotordynamics.whirl import Campbell, FreeRotor, Mode, Motions
from problems.rotor.finite_elements.assembly import Matrices, assemble_free, displacement_row
from problems.rotor.finite_elements.bearing import Pedestal, Support
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.mesh import DOF_PER_NODE
from problems.rotor.free_motion.layout import layout_of
from problems.rotor.free_motion.modes import OVERDAMPED, mode_of, undamped_critical_speeds
from problems.rotor.free_motion.stability import (
    AT_REST,
    NEITHER,
    Held,
    LowModes,
    Pencil,
    finite_eigenvalues,
    growth_rate,
    is_passive,
    low_modes,
    pencils_of,
    towards_symmetric,
)
from problems.rotor.free_motion.static_load import is_held, static_sag, weight_shares

N_MODE = 30  # of the rotor on nominal springs, besides its deflections under forces at its ports
DOUBLE = 1e-7  # relative difference of eigenvalues that are one

# Position (m) of a site, and mass (2, 2), damping and stiffness (n_speed, 2, 2) there at spin speeds (n_speed,)
Attached = tuple[float, Callable[[Array], tuple[Array, Array, Array]]]
Eigenpairs = tuple[ComplexArray, ComplexArray]  # (n,) rad/s, and their coordinates (n_low, n)


@dataclass(frozen=True, eq=False)
class FreeMotion(FreeRotor):
    """A rotor with all numbers given. Its functions are of spin speeds (n_speed,) rad/s."""

    made: Callable[[], Rotor]  # the rotor with all numbers; stability does not need it
    nominal: Rotor  # with bearings about as stiff, whose modes are taken: the same for all values of the bearings
    channels: tuple[Channel, ...]
    # Stiffness N/m, damping N s/m and mass kg of bearings and seals, (n_speed, n_supported, 2, 2) each
    bearings_at: Callable[[Array], tuple[Array, Array, Array]]
    highest: float  # rad/s, frequency and spin speed up to which motions are true
    n_mode: int = N_MODE  # or more
    attached: tuple[Attached, ...] = ()
    supports: tuple[Support, ...] = ()  # of effects, which carry the bearings
    pedestals: tuple[tuple[int, Pedestal], ...] = ()  # of bearings by their index
    effects: tuple[EffectMark, ...] = ()
    left_out: tuple[str, ...] = ()

    @cached_property
    def rotor(self) -> Rotor:
        return self.made()

    def low_at(self, speed: Array) -> LowModes:
        """The rotor without bearings, with what is attached to it."""
        low = low_modes(self.nominal, self.highest, tuple(position for position, _ in self.attached), self.n_mode)
        for index, (_, matrices_at) in enumerate(self.attached):
            low = low.with_attached(index, *matrices_at(speed))
        return low

    def growth_rate(self, speed: Array) -> Array:
        """The largest real part of any damped eigenvalue, (n_speed,) 1/s."""
        return growth_rate(self.low_at(speed), self.held_at(speed))

    def held_at(self, speed: Array) -> Held:
        return Held(speed, *self.bearings_at(speed), self.supports, self.pedestals)

    def is_passive(self, speed: Array) -> bool:
        """Whether nothing can feed a free vibration at these spin speeds.

        It is decided without eigenvalues, as far as that is possible.
        """
        spring, damper, inertia = self.bearings_at(speed)
        parts = [matrices_at(speed) for _, matrices_at in self.attached]
        masses, dampers, springs = ([part[index] for part in parts] for index in range(3))
        for _, pedestal in self.pedestals:
            if pedestal.dynamic_stiffness is not None:
                return False
            of_pedestal = pedestal.matrices()
            springs, dampers, masses = (
                [*each, part.real] for each, part in zip((springs, dampers, masses), of_pedestal)
            )
        all_masses = [inertia, *masses]
        return is_passive(self.nominal, [spring, *springs], [damper, *dampers], all_masses, self.supports)

    @property
    def remarks(self) -> tuple[str, ...]:
        return self.left_out

    def layout(self, speed: float) -> RotorLayout:
        stiffness, damping, _ = (part[0] for part in self.bearings_at(np.array([speed])))
        layout = layout_of(self.rotor, self.channels, stiffness, damping, self.supports, self.effects)
        if not is_held(self.rotor):
            return layout
        places = zip(layout.bearings, weight_shares(self.rotor).tolist())
        bearings = tuple(dataclasses.replace(bearing, load=load) for bearing, load in places)
        return dataclasses.replace(layout, bearings=bearings, sag=static_sag(self.rotor))

    def frequencies(self, speed: Array, *, damped: bool = True) -> Array:
        pencils = self._pencils(speed, float(damped))
        if isinstance(pencils, list):
            scale = self.low_at(speed[:1]).highest
            found = [
                finite_eigenvalues(*scipy.linalg.eigvals(*each, homogeneous_eigvals=True)) * scale for each in pencils
            ]
        else:
            found = list(np.linalg.eigvals(pencils).astype(complex))
        return np.sort(np.stack([np.where(_oscillates(each), each.imag, 0.0) for each in found]), axis=1)

    def motions(self, speed: Array, *, damping: float = 1.0) -> list[Motions]:
        basis = self.low_at(speed[:1]).basis
        rows = basis.reshape(-1, DOF_PER_NODE, basis.shape[1])[:, : len(DIRECTIONS)]
        pairs = self._eigenpairs(speed, damping)
        return [_motions(float(spin), *pair, rows) for spin, pair in zip(speed, pairs)]

    def shapes(self, speed: float, places: Sequence[float]) -> Motions:
        reading = [[displacement_row(self.rotor, place, axis) for axis in DIRECTIONS] for place in places]
        rows = np.array(reading) @ self.low_at(np.array([speed])).basis
        [pair] = self._eigenpairs(np.array([speed]), 1.0)
        return _motions(speed, *pair, rows)

    def undamped_critical_speeds(self, stiffness: float) -> tuple[Array, Array]:
        return undamped_critical_speeds(self.rotor, stiffness, self._free)

    def critical_speeds(self, highest: float, n_scan: int = 64) -> Array:
        """Speeds up to `highest` (rad/s) at which a damped natural frequency equals the spin speed, rising.

        A frequency that crosses twice between two scanned speeds is missed.
        """
        scanned = np.linspace(0.0, highest, n_scan + 1)[1:]
        is_above = self.frequencies(scanned) >= scanned[:, None]

        def excess(speed: float, column: int) -> float:
            return float(self.frequencies(np.array([speed]))[0, column] - speed)

        crossed = zip(*(each.tolist() for each in np.nonzero(is_above[:-1] != is_above[1:])))
        found = [brentq(excess, scanned[at], scanned[at + 1], args=(column,), rtol=1e-10) for at, column in crossed]
        return np.sort(np.array(found))

    def natural_modes(self, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        """Oscillating modes at a spin speed (rad/s) by rising frequency.

        They are the first `n_mode` or all true ones.
        """
        basis = self.low_at(np.array([speed])).basis
        [(values, coordinates)] = self._eigenpairs(np.array([speed]), 1.0)
        oscillating = np.flatnonzero(_oscillates(values))
        order = oscillating[np.argsort(values[oscillating].imag)][:n_mode]
        return tuple(mode_of(complex(values[each]), basis @ coordinates[:, each]) for each in order)

    def campbell(self, speed: Array, n_mode: int) -> Campbell:
        """Natural frequencies and damping ratios of the first `n_mode` modes over spin speeds.

        Spin speeds are (n_speed,) rad/s.
        """
        frequency, damping_ratio = np.full((2, len(speed), n_mode), np.nan)
        for index, motions in enumerate(self.motions(speed)):
            lowest = motions.eigenvalue[:n_mode]
            frequency[index, : len(lowest)] = lowest.imag
            damping_ratio[index, : len(lowest)] = -lowest.real / np.abs(lowest)
        return Campbell(speed, frequency, damping_ratio)

    @cached_property
    def _free(self) -> Matrices:
        return assemble_free(self.rotor)

    def _eigenpairs(self, speed: Array, damping: float) -> list[Eigenpairs]:
        pencils, low = self._pencils(speed, damping), self.low_at(speed[:1])
        n_low = low.basis.shape[1]
        if isinstance(pencils, list):
            solved = (scipy.linalg.eig(*each, homogeneous_eigvals=True) for each in pencils)
            return [(finite_eigenvalues(*values) * low.highest, vectors[:n_low]) for values, vectors in solved]
        values, vectors = np.linalg.eig(pencils)
        return [(each, shapes[:n_low]) for each, shapes in zip(values.astype(complex), vectors.astype(complex))]

    def _pencils(self, speed: Array, damping: float) -> Array | list[Pencil]:
        """State matrices (n_speed, 2 n_low, 2 n_low) of a rotor on rigid ground.

        A rotor on supports has two matrices for each speed. `damping` is the part of all damping, and of the part of
        stiffness that is not symmetric.
        """
        low, held = self.low_at(speed), self.held_at(speed)
        if damping == 1.0:
            return pencils_of(low, held)
        own = low.matrices
        without = dataclasses.replace(
            own,
            stiffness=towards_symmetric(own.stiffness, damping),
            damping=damping * own.damping,
            circulatory=towards_symmetric(own.circulatory, damping),
        )
        return pencils_of(dataclasses.replace(low, matrices=without), held.with_damping(damping))


def free_motion_of(rotor: Rotor, highest: float) -> FreeMotion:
    """Free motion of a rotor whose numbers are all given, up to a frequency and spin speed (rad/s)."""

    def bearings_at(speed: Array) -> tuple[Array, Array, Array]:
        parts = zip(*(bearing.matrices_at(speed) for bearing in rotor.supported))
        stiffness, damping, mass = (np.stack(part, axis=1) for part in parts)
        return stiffness, damping, mass

    own = ((index, bearing.pedestal) for index, bearing in enumerate(rotor.supported))
    pedestals = tuple((index, pedestal) for index, pedestal in own if pedestal is not None)
    return FreeMotion(lambda: rotor, rotor, (), bearings_at, highest, pedestals=pedestals)


def _oscillates(eigenvalue: ComplexArray) -> Array:
    size = np.abs(eigenvalue)
    return np.asarray(eigenvalue.imag > np.maximum(OVERDAMPED * size, AT_REST * np.median(size)))


def _motions(speed: float, eigenvalue: ComplexArray, coordinates: ComplexArray, rows: Array) -> Motions:
    """Oscillating motions, read by `rows` (n_place, 2, n_low)."""
    oscillating = np.flatnonzero(_oscillates(eigenvalue))
    order = oscillating[np.argsort(eigenvalue[oscillating].imag)]
    shape = np.moveaxis(rows @ coordinates[:, order], -1, 0)  # (n, n_place, 2)
    for first in np.flatnonzero(np.abs(np.diff(eigenvalue[order])) <= DOUBLE * np.abs(eigenvalue[order[1:]])).tolist():
        shape[first : first + 2] = _as_circles(shape[first : first + 2])
    flat = shape.reshape(len(shape), -1)
    largest = flat[np.arange(len(flat)), np.argmax(np.abs(flat), axis=1)]
    value = eigenvalue[order]
    value.real[np.abs(value.real) <= NEITHER * np.abs(value)] = 0.0  # neither grows nor decays: rounding has no sign
    return Motions(speed, value, shape / largest[:, None, None])


def _as_circles(pair: ComplexArray) -> ComplexArray:
    """Two shapes (2, n_place, 2) of one frequency as the two sums that whirl forward and backward most.

    On isotropic bearings every sum of a forward and a backward motion of equal frequency is a motion too.
    """
    flat = pair.reshape(2, -1)
    power = flat.conj() @ flat.T
    x, y = np.moveaxis(pair, -1, 0)
    whirl = -1j * (y.conj() @ x.T - x.conj() @ y.T)  # Σ 2 Im(x ȳ) of a sum, as a Hermitian form
    try:
        sums = scipy.linalg.eigh(whirl, power)[1]
    except np.linalg.LinAlgError:  # the same motion twice
        return pair
    return np.einsum("ij,ink->jnk", sums, pair)
