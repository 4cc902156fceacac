"""The banded elimination against the dense route, which shares nothing with it but the matrices."""

import dataclasses

import numpy as np
import pytest

from problems.rotor.finite_elements.assembly import Matrices, assemble
from problems.rotor.response import dense
from problems.rotor.response.banded import DIAGONAL, HALF_BANDWIDTH, dynamic_stiffness_band, solve, solve_both_ways
from problems.three_disk import ThreeDisk

SPEED = np.linspace(20.0, 2000.0, 40)


@pytest.fixture(scope="module")
def matrices():
    """Of the three-disk rotor on its bearings, with internal damping, so that none of the five is empty."""
    return assemble(dataclasses.replace(ThreeDisk(mesh=17).build().rotor, internal_damping=1e-5))


def test_the_band_holds_all_of_the_dynamic_stiffness(matrices):
    band, full = dynamic_stiffness_band(matrices, SPEED), dense.dynamic_stiffness(matrices, SPEED)
    n = full.shape[1]
    rebuilt = np.zeros_like(full)
    for column in range(n):
        for row in range(max(0, column - HALF_BANDWIDTH), min(n, column + HALF_BANDWIDTH + 1)):
            rebuilt[:, row, column] = band[:, column, DIAGONAL + row - column]
    assert rebuilt == pytest.approx(full, rel=1e-14, abs=1e-12 * np.abs(full).max())


def test_solutions_agree_with_dense_ones(matrices):
    """Both are backward stable: they part by rounding times the condition of a rotor away from its resonances."""
    rng = np.random.default_rng(0)
    force = rng.standard_normal((len(SPEED), len(matrices.mass), 5, 2)) @ [1, 1j]
    found = solve(dynamic_stiffness_band(matrices, SPEED), force)
    expected = np.linalg.solve(dense.dynamic_stiffness(matrices, SPEED), force)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


def test_a_singular_rotor_is_refused():
    none = np.zeros((8, 8))
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        solve(dynamic_stiffness_band(Matrices(none, none, none, none, none), SPEED[:2]), np.ones((2, 8, 1), complex))


def test_motion_and_adjoint_rows_agree_with_dense_ones(matrices):
    rng = np.random.default_rng(1)
    n_dof = len(matrices.mass)
    force = rng.standard_normal((len(SPEED), n_dof, 3, 2)) @ [1, 1j]
    rows = rng.standard_normal((4, n_dof))
    motion, seen = solve_both_ways(dynamic_stiffness_band(matrices, SPEED), force, rows)
    inverse = np.linalg.inv(dense.dynamic_stiffness(matrices, SPEED))
    for found, expected in ((motion, inverse @ force), (seen, rows @ inverse)):  # within rounding times the condition
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
