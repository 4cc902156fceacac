"""Changes of a rotor at a few of its degrees of freedom, by its receptances there.

With the receptance H of the rotor without the change, between these degrees of freedom a and all that reads or loads the rotor, a change
ΔD of its dynamic stiffness gives

    H ← H − H[:, a] (1 + ΔD H[a, a])⁻¹ ΔD H[a, :],

the structural modification of H. N. Özgüven (Mech. Syst. Signal Process. 4 (1990) 53–63, doi 10.1016/0888-3270(90)90040-R). The shaft is
then solved once for all changes there.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.measurement.channel import Channel
from ksmea.problem.load import Load
from problems.rotor.extension.matrix_slope import MatrixSlope
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import force_per_unbalance, unit_loads
from problems.rotor.finite_elements.mesh import DOF_PER_NODE
from problems.rotor.response.dense import channel_rows
from problems.rotor.response.receptance import Reduction

MOST_DOF = 12  # of three nodes: with many more, a solution of the whole shaft costs as little
KEPT_BYTES = 2**28  # of reductions that problems with effects on one rotor share
CHANGEABLE = ("segments", "disks", "masses", "hubs")  # fields of a rotor that do nothing but enter its matrices


@dataclass(frozen=True, eq=False)
class LocalChanges:
    """A rotor that is also seen from the few degrees of freedom at which others differ from it."""

    rotor: Rotor
    dof: Indices  # (n,), sorted
    reduction: Reduction  # whose last n rows and columns are these

    @classmethod
    def between(
        cls,
        rotor: Rotor,
        others: Iterable[Rotor],
        seen: Callable[[ComplexArray, Array], Reduction],
        channels: Sequence[Channel],
        loads: Sequence[Load],
        n_speed: int,
    ) -> LocalChanges | None:
        """Changes from a rotor to others, as read by channels under unbalance and unit loads.

        None if the matrices differ at more than `MOST_DOF` degrees of freedom, or if not they alone differ: bearings, loads, or what
        channels read. `seen` reduces the rotor under nodal forces (n_speed, n_dof, n), seen also by rows (n, n_dof).
        """
        found: set[int] = set()
        for other in others:
            if not _differ_in_matrices_alone(rotor, other, channels, loads):
                return None
            found.update(map(int, MatrixSlope.between(rotor, other, 1.0).dof))
            if len(found) > MOST_DOF:
                return None
        if not found:
            return None
        dof = np.array(sorted(found), dtype=int)
        rows = np.eye(DOF_PER_NODE * len(rotor.node_positions))[dof]
        columns = np.concatenate([*(unit_loads(rotor, [load], 1)[0] for load in loads), rows.T], axis=1)
        forces = np.broadcast_to(columns.astype(complex), (n_speed, *columns.shape))
        return cls(rotor, dof, seen(forces, rows))

    def reduction_of(self, other: Rotor) -> Reduction | None:
        """The reduction of another rotor, these degrees of freedom included; None if it differs elsewhere too."""
        difference, n, speed = MatrixSlope.between(self.rotor, other, 1.0), len(self.dof), self.reduction.speed
        place = self.places_of(difference.dof)
        if place is None:
            return None
        change = np.zeros((len(speed), n, n), dtype=complex)
        change[:, place[:, None], place] = difference.dynamic_stiffness(speed)
        receptance = np.moveaxis(self.reduction.receptance, 2, 0)
        felt = change @ receptance[:, -n:]
        moved = np.linalg.solve(np.eye(n) + felt[:, :, -n:], felt)
        changed = receptance - receptance[:, :, -n:] @ moved
        return dataclasses.replace(self.reduction, receptance=np.ascontiguousarray(np.moveaxis(changed, 0, 2)))

    def without_dof(self, reduction: Reduction) -> Reduction:
        """A reduction of a changed rotor without these degrees of freedom."""
        n = len(self.dof)
        return dataclasses.replace(reduction, receptance=np.ascontiguousarray(reduction.receptance[:-n, :-n]))

    def places_of(self, dof: Indices) -> Indices | None:
        """Indices of some degrees of freedom among these; None if they are not all among them."""
        return np.searchsorted(self.dof, dof) if np.all(np.isin(dof, self.dof)) else None


def most_kept(n_speed: int) -> int:
    """Number of local changes of one rotor that are kept, by the memory of such with 30 rows and columns.

    >>> most_kept(50), most_kept(2000)
    (372, 9)
    """
    return max(1, KEPT_BYTES // (n_speed * 30 * 30 * 16))


def _differ_in_matrices_alone(one: Rotor, other: Rotor, channels: Sequence[Channel], loads: Sequence[Load]) -> bool:
    """Whether two rotors have equal bearings, forces of unbalance and of unit loads, and rows of channels."""
    spin = np.ones(1)
    return (
        dataclasses.replace(one, **{name: getattr(other, name) for name in CHANGEABLE}) == other
        and np.array_equal(channel_rows(one, channels), channel_rows(other, channels))
        and np.array_equal(force_per_unbalance(one, spin), force_per_unbalance(other, spin))
        and (not loads or np.array_equal(unit_loads(one, loads, 1), unit_loads(other, loads, 1)))
    )
