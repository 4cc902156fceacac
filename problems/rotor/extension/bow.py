"""Shapes of a bent shaft, and the load by which it turns with its bend.

The shaft's elastic force is K_s (q − q_b), so that its own stiffness times the bow acts as a load that is the same at all speeds:
D(Ω) q = f + K_s q_b, with q_b = w(z) (1, −i) forward. K_s does not feel a straight line added to w, and probes read the bow
together with the vibration, less the line through the outer bearings. Shapes, each of unit size:

- `sine`: half a sine between the outer bearings, w = sin(π (z − a)/(b − a)), and straight outside of them along its tangents;
- `whole`: half a sine over the whole shaft, w = sin(π z/L);
- `force at z`, `moment at z`: the shaft as a force or a moment at z bends it at rest, on hinges at the outer bearings, with a
  largest deflection of 1. A weld, a press fit or a coupling at z leaves such a shape.

Only a rotor that was drawn, of a file, is tried in every shape. Data that show k modes determine k complex numbers of a bow and not its shape, so that several shapes fit about as well, each with
an unbalance of its own.

J. C. Nicholas, E. J. Gunter & P. E. Allaire, Effect of residual shaft bow on unbalance response and balancing of a single mass
flexible rotor, J. Eng. Power 98 (1976) 171–189; Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapter 6.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import ClassVar, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.plugins.effect import SizeRecord, StatementRecord
from ksmea.problem.load import FORCE, LOADS, MOMENT
from ksmea.settings.settings import setting
from ksmea.units import MICROMETRE
from problems.rotor.extension.effect import RotorEffect, distinct, is_near
from problems.rotor.extension.sizes import VectorSize
from problems.rotor.finite_elements import shaft
from problems.rotor.finite_elements.assembly import assemble_free, displacement_row, element_dof
from problems.rotor.finite_elements.data import SAME_PLACE, Rotor
from problems.rotor.finite_elements.loads import forward_load
from problems.rotor.finite_elements.mesh import DOF_PER_NODE, element_at
from problems.rotor.response.problem import RotorProblem

LARGEST = 100 * MICROMETRE  # a rotor bent more than this is straightened before it is run
NOTICED = (0.3 * MICROMETRE, 30 * MICROMETRE)  # vectors as long as these are drawn
LONG_SPAN = 0.25  # of the shaft's length, between disks, couplings, bearings and ends: bent in its middle too
N_SAMPLE = 201  # places at which the largest deflection is sought
REACH = 0.2  # of length and slopes by which an element bends beyond its ends; 4/27 of each in a plain one
NEARLY = 0.9  # of the largest deflection of a node: elements that stay below have no larger one
SINE, WHOLE = "sine", "whole"
AT = " at "
IN_WORDS = {SINE: "half sine between the bearings", WHOLE: "half sine over the whole shaft"}


@dataclass(frozen=True)
class Bow(RotorEffect):
    """Base of effects that bend the shaft in one or two shapes."""

    shapes: list[str] = setting(
        [SINE],
        "one or two: sine (half a sine between the bearings, straight outside), whole (half a sine over the shaft), or as under a load"
        " at rest, such as 'force at 0.5' or 'moment at 0.5' (m)",
    )

    vector: ClassVar[str]  # name of its unknowns
    bends: ClassVar[str]  # the beginning of the sentence about it

    @property
    def sizes(self) -> Sequence[VectorSize]:
        names = (self.vector, f"{self.vector}_2")[: len(self.shapes)]
        return tuple(VectorSize(name, "µm", LARGEST, drawn=NOTICED) for name in names)

    def __str__(self) -> str:
        return " and ".join(map(in_words, self.shapes))

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        """Each shape with its size."""
        parts = [
            f"by {{{name}:reading}} {_where(shape)}" for name, shape in zip(self.vectors(), self.shapes, strict=True)
        ]
        return dataclasses.replace(super().statement(sizes), sentence=f"{self.bends} {' and '.join(parts)}")

    def check(self) -> None:
        if not 1 <= len(set(self.shapes)) == len(self.shapes) <= 2:
            raise SettingError(f"shapes: expected one or two that differ, got {self.shapes}")
        for shape in self.shapes:
            in_words(shape)

    def locations(self, problem: RotorProblem) -> Sequence[Self]:
        """In each shape; half a sine between the bearings if the rotor is not a drawing."""
        return [self._bent([shape]) for shape in bow_shapes(problem.rotor)] if problem.is_as_drawn else [self]

    def kin(self, problem: RotorProblem) -> Sequence[Self]:
        """In two shapes."""
        shapes = bow_shapes(problem.rotor) if problem.is_as_drawn else []
        return [self._bent([*pair]) for pair in combinations(shapes, 2)]

    def caveat(self, problem: RotorProblem) -> str:
        if not self.kin(problem):
            return ""
        return (
            "the shape of the bend decides the unbalance, and the data hardly determine that shape; use the averaged values, which are over"
            " the shapes that fit about as well, and run with a trial weight or measure the bend at standstill for narrower intervals"
        )

    def _bent(self, shapes: list[str]) -> Self:
        return dataclasses.replace(self, shapes=shapes)

    def load_sizes(self, theta: Array) -> ComplexArray:
        return np.asarray(theta[:, ::2] + 1j * theta[:, 1::2], dtype=complex)

    def bow_loads(self, rotor: Rotor, part: Array) -> ComplexArray:
        """The nodal forces of parts (n_speed,) of a unit bow in each shape, (n_speed, n_dof, n_shape)."""
        columns = [bow_load(rotor, shape) for shape in self.shapes]
        return np.asarray(part[:, None, None] * np.stack(columns, axis=-1), dtype=complex)


def bow_shapes(rotor: Rotor) -> list[str]:
    """Shapes that a rotor may be bent in."""
    bearings = [bearing.position for bearing in rotor.bearings]
    if len(set(bearings)) < 2:
        return [WHOLE]
    left, right = min(bearings), max(bearings)
    is_overhung = left > SAME_PLACE * rotor.length or rotor.length - right > SAME_PLACE * rotor.length
    places = _loaded_places(rotor)
    forces = [place for place in places if not (is_near(place, left) or is_near(place, right))]
    static = [f"{kind}{AT}{place:.12g}" for kind, those in ((FORCE, forces), (MOMENT, places)) for place in those]
    return [SINE, *([WHOLE] if is_overhung else []), *static]


def _loaded_places(rotor: Rotor) -> list[float]:
    """Disks, couplings, and the middle of long spans between them, bearings and ends, m; each once."""
    seats = [*(disk.position for disk in rotor.disks), *rotor.couplings]
    stations = sorted([0.0, rotor.length, *seats, *(bearing.position for bearing in rotor.bearings)])
    middles = [(left + right) / 2 for left, right in pairwise(stations) if right - left > LONG_SPAN * rotor.length]
    return distinct([*seats, *middles], rotor)


def in_words(shape: str) -> str:
    """A shape in words; `SettingError` for one that is unknown."""
    if shape in IN_WORDS:
        return IN_WORDS[shape]
    kind, place = _load_of(shape)
    return f"as under a {kind} at {place:g} m"


def _where(shape: str) -> str:
    """Words for the place at which a shape has its size."""
    return "in its middle" if shape in IN_WORDS else f"at most, {in_words(shape)}"


def _load_of(shape: str) -> tuple[str, float]:
    kind, _, place = shape.partition(AT)
    try:
        position = float(place.removesuffix(" m"))
    except ValueError:
        position = np.nan
    if kind not in LOADS or not np.isfinite(position):
        raise SettingError(f"shapes: expected sine, whole, or a load such as 'force at 0.5', got '{shape}'")
    return kind, position


def bow_load(rotor: Rotor, shape: str) -> ComplexArray:
    """The nodal forces K_s q_b of a unit bow, (n_dof,)."""
    elastic = assemble_free(dataclasses.replace(rotor, axial_force=0.0)).stiffness  # an axial force has no memory
    return np.asarray(elastic @ bow_shape(rotor, shape, elastic))


def bow_shape(rotor: Rotor, shape: str, elastic: Array) -> ComplexArray:
    """Forward bow of unit size in the rotor's degrees of freedom (x, y, φ_x, φ_y), (n_dof,).

    The shaft has a stiffness (n_dof, n_dof) N/m.
    """
    bearings = [bearing.position for bearing in rotor.bearings]
    if shape == WHOLE or (shape == SINE and len(set(bearings)) < 2):
        return half_sine(rotor.node_positions, 0.0, rotor.length)
    left, right = _outer(bearings)
    if shape == SINE:
        return half_sine(rotor.node_positions, left, right)
    return _static_shape(rotor, shape, elastic, (left, right))


def _outer(bearings: Sequence[float]) -> tuple[float, float]:
    if len(set(bearings)) < 2:
        raise SettingError(
            f"shapes: expected two bearings to bend a shaft on, got {len(set(bearings))}; take the shape '{WHOLE}'"
        )
    return min(bearings), max(bearings)


def half_sine(position: Array, left: float, right: float) -> ComplexArray:
    """Half a sine between two positions (m), with its tangents outside, (4 n_node,).

    >>> half_sine(np.array([0.0, 1.0, 2.0, 3.0]), 0.0, 2.0)[::4].real.round(4) + 0.0
    array([ 0.    ,  1.    ,  0.    , -1.5708])
    """
    inside = np.clip(position, left, right)
    argument, rate = np.pi * (inside - left) / (right - left), np.pi / (right - left)
    slope = rate * np.cos(argument)
    deflection = np.sin(argument) + slope * (position - inside)
    # φ_y = dw_x/dz and φ_x = −dw_y/dz with w_y = −i w_x
    return np.stack([deflection, -1j * deflection, 1j * slope, slope], axis=-1).ravel()


def _static_shape(rotor: Rotor, shape: str, elastic: Array, hinges: tuple[float, float]) -> ComplexArray:
    """K_s w = f − Pᵀ r with the reactions r of hinges, P w = 0."""
    kind, place = _load_of(shape)
    load = forward_load(rotor, place, kind, 1)[0, :, 0]
    pins = np.stack([displacement_row(rotor, hinge, axis) for hinge in hinges for axis in ("x", "y")])
    scale = float(np.max(np.abs(np.diag(elastic))))
    whole = np.block([[elastic, scale * pins.T], [scale * pins, np.zeros((len(pins), len(pins)))]])
    try:
        bent = np.linalg.solve(whole, np.concatenate([load, np.zeros(len(pins))]))[: len(load)]
    except np.linalg.LinAlgError as error:
        raise SettingError(
            f"shapes: expected a shaft that bends, got joints without stiffness; leave '{shape}' out"
        ) from error
    return np.asarray(bent / _largest_along_x(rotor, bent))  # complex, as a moment about x bends the shaft along y


def _largest_along_x(rotor: Rotor, motion: ComplexArray) -> complex:
    """Motion along x where it is largest, of `N_SAMPLE` places on the shaft."""
    nodes, places = rotor.node_positions, np.linspace(0, rotor.length, N_SAMPLE)
    deflection, slope = (np.abs(motion[dof::DOF_PER_NODE]) for dof in (0, 3))
    between = np.maximum(deflection[1:], deflection[:-1]) + REACH * np.diff(nodes) * (slope[1:] + slope[:-1])
    owner = np.clip(np.searchsorted(nodes, places, side="right") - 1, 0, len(nodes) - 2)
    found = []
    for index in np.flatnonzero(between >= NEARLY * np.max(deflection)):
        fractions = np.clip((places[owner == index] - nodes[index]) / (nodes[index + 1] - nodes[index]), 0.0, 1.0)
        shapes = shaft.deflection_along(element_at(rotor, int(index)), fractions)
        found.append(shapes @ (shaft.X_PLANE @ motion[element_dof(int(index))]))
    along = np.concatenate(found)
    return complex(along[np.argmax(np.abs(along))])
