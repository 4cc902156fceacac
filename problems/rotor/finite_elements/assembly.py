"""Global matrices of a rotor, the rigid disk, and rows that read the deflection anywhere on the shaft.

M q̈ + (C + Ω G) q̇ + (K + Ω N) q = f, with the degrees of freedom (x, y, φ_x, φ_y) node by node. N is circulatory: it
comes with damping that turns with the shaft, which sees the velocity q̇ − Ω × q.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import TypeVar

import numpy as np

from ksmea.arrays import Array, Indices
from ksmea.measurement.channel import DIRECTIONS
from problems.rotor.finite_elements import shaft
from problems.rotor.finite_elements.beside_node import bearing_rows, disk_rows
from problems.rotor.finite_elements.data import SAME_PLACE, Hub, Rotor
from problems.rotor.finite_elements.mesh import DOF_PER_NODE, Element, element_at, elements, locate
from problems.rotor.finite_elements.segments import CouplingSegment, Disk, ShaftSegment

Of = TypeVar("Of")
MAX_KEPT = 16  # assembled rotors: many effects leave the rotor as it is, and fits come back to where they were

# −(Ω ẑ ×) per unit of Ω on the degrees of freedom of a node; the shaft turns from x to y.
AGAINST_SPIN = np.kron(np.eye(2), [[0.0, 1.0], [-1.0, 0.0]])


@dataclass(frozen=True, eq=False)
class Matrices:
    """Matrices of a rotor, each (n_dof, n_dof).

    They hold the turning and the standing parts together.
    """

    mass: Array
    damping: Array
    gyroscopic: Array
    stiffness: Array
    circulatory: Array
    # H, N/m, of hysteretic damping that turns with the shaft, which sees forward whirl at ω − Ω and backward whirl at ω + Ω: a force
    # iH q in each, with the sign of its frequency. None: there is none
    hysteretic: Array | None = None

    def on(self, basis: Array) -> Matrices:
        """These in the space of a basis (n_dof, n)."""
        parts = (self.mass, self.damping, self.gyroscopic, self.stiffness, self.circulatory)
        mass, damping, gyroscopic, stiffness, circulatory = (basis.T @ part @ basis for part in parts)
        hysteretic = None if self.hysteretic is None else basis.T @ self.hysteretic @ basis
        return Matrices(mass, damping, gyroscopic, stiffness, circulatory, hysteretic)

    def hysteresis(self, harmonic: float) -> tuple[Array, Array] | None:
        """Real and imaginary part of the dynamic stiffness that H adds to a motion at ω = hΩ.

        It is iH (sgn(h − 1) P_f + P_b), P_f and P_b being the parts of a motion that whirl forward and backward
        (E. S. Zorzi & H. D. Nelson, J. Eng. Power 99 (1977) 71–76).
        """
        if self.hysteretic is None:
            return None
        sign, crossed = float(np.sign(harmonic - 1)), self._crossed
        return (1 - sign) / 2 * crossed, (1 + sign) / 2 * self.hysteretic

    @property
    def _crossed(self) -> Array:
        assert self.hysteretic is not None
        return against_spin(self.hysteretic)

    def below_spin(self) -> Matrices:
        """Damping for free vibrations slower than the spin.

        H drives their forward whirl and damps their backward whirl, whatever the frequency; faster forward ones are
        damped by it, and are not here.
        """
        if self.hysteretic is None:
            return self
        return replace(self, stiffness=self.stiffness + self._crossed, hysteretic=None)


def against_spin(turning: Array) -> Array:
    """The circulatory matrix N (n_dof, n_dof) of damping C that turns with the shaft, C (q̇ − Ω × q)."""
    return np.asarray(turning @ np.kron(np.eye(len(turning) // DOF_PER_NODE), AGAINST_SPIN))


def assemble(rotor: Rotor, speed: float = 0.0) -> Matrices:
    """Matrices of a rotor on its bearings and seals; tables are read at the spin speed (rad/s).

    Housings on pedestals have two degrees of freedom each, behind the shaft's. A pedestal's loss factor makes its
    stiffness complex (for motions of positive frequency). Its measured dynamic stiffness becomes the spring and the
    damper that it is at the frequency of rotation.
    """
    free, supported = assemble_free(rotor).below_spin(), rotor.supported
    n_dof = len(free.mass)
    housings = [index for index, bearing in enumerate(supported) if bearing.pedestal is not None]
    n_whole = n_dof + 2 * len(housings)
    mass, damping, gyroscopic, stiffness, circulatory = (
        np.pad(part, (0, n_whole - n_dof))
        for part in (free.mass, free.damping, free.gyroscopic, free.stiffness, free.circulatory)
    )
    for index, bearing in enumerate(supported):
        relative = np.zeros((2, n_whole))
        dof, rows = bearing_rows(rotor, bearing)
        relative[:, dof] = rows
        if bearing.pedestal is not None:
            start = n_dof + 2 * housings.index(index)
            housing = slice(start, start + 2)
            relative[[0, 1], [start, start + 1]] = -1.0
            elastic, viscous, inertia = bearing.pedestal.matrices(speed)
            if np.any(elastic.imag):
                stiffness = stiffness.astype(complex)
                stiffness.imag[housing, housing] += elastic.imag
            stiffness.real[housing, housing] += elastic.real
            damping[housing, housing] += viscous
            mass[housing, housing] += inertia
        touched = np.flatnonzero(np.any(relative, axis=0))
        place, sides = np.ix_(touched, touched), relative[:, touched]
        own = (part[0] for part in bearing.matrices_at(np.array([speed])))
        for matrix, part in zip((stiffness, damping, mass), own):
            matrix[place] += sides.T @ part @ sides
    return Matrices(mass, damping, gyroscopic, stiffness, circulatory)


@lru_cache(maxsize=MAX_KEPT)
def assemble_free(rotor: Rotor) -> Matrices:
    """The matrices of the shaft and its disks alone, without bearings.

    They are kept, and not to be written to.
    """
    seated = [_seated(rotor, disk) for disk in (*rotor.disks, *rotor.masses)]
    found = _assembled(rotor, range(len(rotor.segments)), seated, range(len(rotor.node_positions)))
    for matrix in (found.mass, found.damping, found.gyroscopic, found.stiffness, found.circulatory, found.hysteretic):
        if matrix is not None:
            matrix.flags.writeable = False
    return found


@dataclass(frozen=True)
class _Seated:
    """A disk or lumped mass, degrees of freedom (n,) that move it, and rows (4, n) that read it."""

    disk: Disk
    dof: Indices
    rows: Array


def _seated(rotor: Rotor, disk: Disk) -> _Seated:
    return _Seated(disk, *disk_rows(rotor, disk))


def assemble_differing(first: Rotor, second: Rotor) -> tuple[Indices, Matrices, Matrices]:
    """Matrices of the parts in which two rotors differ, on the degrees of freedom that move these parts.

    Whole matrices differ by as much.
    """
    of_shaft = ("internal_damping", "external_damping", "axial_force")
    if any(getattr(first, name) != getattr(second, name) for name in of_shaft):
        segments: Sequence[int] = range(len(first.segments))
    else:
        pairs = zip(first.segments, second.segments, strict=True)
        hubs, others = Counter(first.hubs), Counter(second.hubs)
        under = _under(first, (hubs - others) + (others - hubs))
        segments = [index for index, pair in enumerate(pairs) if index in under or _differ(*pair)]
    pairs_of_disks = zip((*first.disks, *first.masses), (*second.disks, *second.masses), strict=True)
    differing = [  # off its node, a disk moves as the shaft does
        pair for pair in pairs_of_disks if _differ(*pair) or (segments and any(disk.offset for disk in pair))
    ]
    seated = [[_seated(rotor, pair[side]) for pair in differing] for side, rotor in enumerate((first, second))]
    touched = [int(dof) // DOF_PER_NODE for each in itertools.chain(*seated) for dof in (each.dof[0], each.dof[-1])]
    touched += [node for element in _elements_of(first, segments) for node in (element, element + 1)]
    window = range(min(touched), max(touched) + 1) if touched else range(0)
    one, other = (_assembled(rotor, segments, own, window) for rotor, own in zip((first, second), seated))
    return DOF_PER_NODE * window.start + np.arange(DOF_PER_NODE * len(window)), one, other


def _under(rotor: Rotor, hubs: Collection[Hub]) -> set[int]:
    """Indices of the segments that hubs reach."""
    if not hubs:
        return set()
    ends = list(itertools.accumulate((segment.length for segment in rotor.segments), initial=0.0))
    reach = [(hub.position - hub.width / 2, hub.position + hub.width / 2) for hub in hubs]
    near = SAME_PLACE * rotor.length  # by rounding, too many rather than too few
    return {
        index
        for index, (left, right) in enumerate(itertools.pairwise(ends))
        if any(low < right + near and high > left - near for low, high in reach)
    }


def _differ(one: object, other: object) -> bool:
    """Whether two parts differ, most of which are one object."""
    return one is not other and one != other


def _assembled(rotor: Rotor, segments: Sequence[int], seated: Sequence[_Seated], window: range) -> Matrices:
    """Matrices of some segments and disks of a rotor on the degrees of freedom of consecutive nodes.

    These are all that move them.
    """
    place = partial(_placed, rotor, segments, window)
    matrices = of_elements(rotor, shaft.element_matrices, segments)
    mass = place([each.mass for each in matrices])
    gyroscopic = place([each.gyroscopic for each in matrices])
    stiffness = place([each.stiffness for each in matrices])
    for each in seated:
        at = _at(each, window)
        mass[at] += each.rows.T @ shaft.disk_mass(each.disk) @ each.rows
        gyroscopic[at] += each.rows.T @ shaft.disk_gyroscopic(each.disk) @ each.rows
    circulatory, damping = np.zeros_like(stiffness), np.zeros_like(stiffness)
    if rotor.internal_damping:
        damping = rotor.internal_damping * stiffness
        circulatory = against_spin(damping)
    if rotor.external_damping:
        damping = damping + rotor.external_damping * place(of_elements(rotor, shaft.drag, segments))
    if rotor.axial_force:
        tension = place(of_elements(rotor, shaft.geometric_stiffness, segments))
        stiffness = stiffness + rotor.axial_force * tension
    if any(each.disk.standing_damping for each in seated):
        damping = damping.copy()
        for each in seated:
            own = each.rows.T @ shaft.disk_mass(each.disk) @ each.rows
            damping[_at(each, window)] += each.disk.standing_damping * own
    if not all(isinstance(segment, ShaftSegment) and _is_plain(segment) for segment in rotor.segments):
        turning = place(of_elements(rotor, shaft.segment_internal_damping, segments))
        damping = damping + turning + place(of_elements(rotor, shaft.segment_damping, segments))
        circulatory = circulatory + against_spin(turning)
        stiffness = stiffness + place(of_elements(rotor, shaft.segment_tension, segments))
    hysteretic = None
    if any(isinstance(segment, ShaftSegment) and segment.loss_factor for segment in rotor.segments):
        hysteretic = place(of_elements(rotor, shaft.segment_loss, segments))
    return Matrices(mass, damping, gyroscopic, stiffness, circulatory, hysteretic)


def _at(each: _Seated, window: range) -> tuple[Indices, Indices]:
    """Rows and columns of a disk in matrices of these nodes."""
    dof = each.dof - DOF_PER_NODE * window.start
    return dof[:, None], dof[None]


def _is_plain(segment: ShaftSegment) -> bool:
    """Whether a segment has no damping or tension of its own."""
    return not (segment.axial_force or segment.internal_damping or any(segment.standing_damping))


def of_elements(rotor: Rotor, matrices: Callable[[Element], Of], segments: Sequence[int] | None = None) -> list[Of]:
    """Matrices of each element of some segments, from left to right, that do not depend on its position.

    Computed once for each form of element. None: of all segments.
    """
    chosen = range(len(rotor.segments)) if segments is None else segments
    own = [rotor.segments[index] for index in chosen]
    are_alike = all(isinstance(each, CouplingSegment) or each.is_cylinder for each in own)
    if are_alike and not rotor.hubs:
        of_segment = {segment: matrices(Element(segment, 0.0)) for segment in set(own)}
        return [of_segment[segment] for segment in own for _ in range(segment.n_element)]
    of_form: dict[object, Of] = {}
    whole = elements(rotor)
    found = []
    for element in (whole[index] for index in _elements_of(rotor, chosen)):
        form = element.segment, element.hubs, element.ends
        if form not in of_form:
            of_form[form] = matrices(element)
        found.append(of_form[form])
    return found


def _elements_of(rotor: Rotor, segments: Sequence[int]) -> list[int]:
    """Indices of the elements of some segments."""
    ends = list(itertools.accumulate((segment.n_element for segment in rotor.segments), initial=0))
    return [element for index in segments for element in range(ends[index], ends[index + 1])]


def chained(matrices: Sequence[Array]) -> Array:
    """Matrices of elements (8, 8), from left to right, as one of the whole shaft."""
    return _at_elements(matrices, np.arange(len(matrices)), len(matrices) + 1)


def _placed(rotor: Rotor, segments: Sequence[int], window: range, matrices: Sequence[Array]) -> Array:
    """Matrices of the elements of some segments, as one of consecutive nodes."""
    return _at_elements(matrices, np.array(_elements_of(rotor, segments), dtype=int) - window.start, len(window))


def _at_elements(matrices: Sequence[Array], left: Indices, n_node: int) -> Array:
    """Matrices of elements behind these nodes as one of all nodes."""
    n = DOF_PER_NODE
    whole = np.zeros((n_node, n, n_node, n))
    if len(matrices):
        blocks = np.array(matrices)
        for row, rows in ((left, slice(None, n)), (left + 1, slice(n, None))):
            for column, columns in ((left, slice(None, n)), (left + 1, slice(n, None))):
                whole[row, :, column] += blocks[:, rows, columns]
    return whole.reshape(n * n_node, n * n_node)


def displacement_row(rotor: Rotor, position: float, direction: str) -> Array:
    """Row (n_dof,) that reads the deflection in a direction at a position (m).

    Directions are as in `ksmea.measurement.channel`; the shape functions are the element's own.

    Its transpose spreads a force at that position over the nodes consistently.
    """
    index, fraction = locate(rotor, position)
    row = np.zeros(DOF_PER_NODE * len(rotor.node_positions))
    row[element_dof(index)] = shaft.displacement_row(element_at(rotor, index), fraction, direction)
    return row


def rotation_row(rotor: Rotor, position: float, axis: str) -> Array:
    """Row (n_dof,) that reads the rotation of the section about an axis, x or y, at a position (m).

    Its transpose spreads a moment at that position over the nodes consistently.
    """
    index, fraction = locate(rotor, position)
    row = np.zeros(DOF_PER_NODE * len(rotor.node_positions))
    row[element_dof(index)] = shaft.rotation_rows(element_at(rotor, index), fraction)[DIRECTIONS.index(axis)]
    return row


def node_dof(node: int) -> Indices:
    return DOF_PER_NODE * node + np.arange(DOF_PER_NODE)


def element_dof(element: int) -> slice:
    return slice(DOF_PER_NODE * element, DOF_PER_NODE * (element + 2))
