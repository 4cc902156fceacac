"""Slopes of a rotor's matrices with one of its numbers, and their products with motions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ksmea.arrays import Array, ComplexArray, Indices
from problems.rotor.finite_elements.assembly import Matrices, assemble_differing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.dense import dynamic_stiffness

NAMES = ("stiffness", "circulatory", "mass", "damping", "gyroscopic")


@dataclass(frozen=True, eq=False)
class MatrixSlope:
    """∂/∂x of the matrices of the free rotor, where they are not 0: on these degrees of freedom."""

    dof: Indices
    matrices: Mapping[str, Array]  # (n, n), per SI unit
    hysteresis: tuple[Array, Array] | None  # real and imaginary part at 1X

    @classmethod
    def between(cls, below: Rotor, above: Rotor, width: float) -> MatrixSlope:
        dof, first, second = assemble_differing(below, above)
        parts = {name: (getattr(second, name) - getattr(first, name)) / width for name in NAMES}
        parts = {name: part for name, part in parts.items() if np.any(part)}
        hysteresis = _hysteresis_between(first, second, width)
        whole = [*parts.values(), *(hysteresis or ())]
        touched = (
            np.flatnonzero(np.any([np.any(part, axis=0) for part in whole], axis=0)) if whole else np.empty(0, int)
        )
        place = np.ix_(touched, touched)
        cut = None if hysteresis is None else (hysteresis[0][place], hysteresis[1][place])
        return cls(dof[touched], {name: part[place] for name, part in parts.items()}, cut)

    def dynamic_stiffness(self, speed: Array) -> ComplexArray:
        """∂D/∂x (n_speed, n, n), N/m per SI unit, between these degrees of freedom."""
        none = np.zeros((len(self.dof), len(self.dof)))
        whole = dynamic_stiffness(Matrices(**{name: self.matrices.get(name, none) for name in NAMES}), speed)
        return whole if self.hysteresis is None else whole + self.hysteresis[0] + 1j * self.hysteresis[1]

    def times(self, speed: Array, motion: ComplexArray) -> ComplexArray:
        """∂D/∂x q at these degrees of freedom, of motions (n_speed, n_dof, n_column)."""
        n_speed, _, n_column = motion.shape
        own = np.ascontiguousarray(motion[:, self.dof].transpose(1, 0, 2)).reshape(len(self.dof), n_speed * n_column)
        omega = np.repeat(speed, n_column)
        factors: dict[str, NDArray[Any]] = {
            "stiffness": np.ones_like(omega),
            "circulatory": omega,
            "mass": -(omega**2),
            "damping": 1j * omega,
            "gyroscopic": 1j * omega**2,
        }
        total = np.zeros_like(own)
        for name, matrix in self.matrices.items():
            total += factors[name] * _product(matrix, own)
        if self.hysteresis is not None:
            total += _product(self.hysteresis[0], own) + 1j * _product(self.hysteresis[1], own)
        return total.reshape(len(total), n_speed, n_column).transpose(1, 0, 2)


def _product(matrix: Array, columns: ComplexArray) -> ComplexArray:
    """A real matrix (n, n) times contiguous columns (n, m), in half of the work of a complex product."""
    return (matrix @ columns.view(float)).view(complex)


def _hysteresis_between(first: Matrices, second: Matrices, width: float) -> tuple[Array, Array] | None:
    before, after = first.hysteresis(1.0), second.hysteresis(1.0)
    if before is None and after is None:
        return None
    none = np.zeros_like(first.stiffness)
    before, after = before or (none, none), after or (none, none)
    return (after[0] - before[0]) / width, (after[1] - before[1]) / width
