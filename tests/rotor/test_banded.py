"""The banded elimination against the dense route, which shares nothing with it but the matrices."""

import dataclasses

import numpy as np
import pytest

from ksmea.problem.load import Load
from problems.rotor.finite_elements.assembly import Matrices, assemble
from problems.rotor.finite_elements.loads import unit_loads
from problems.rotor.response import dense, receptance
from problems.rotor.response.banded import (
    DIAGONAL,
    HALF_BANDWIDTH,
    dynamic_stiffness_band,
    factorised,
    solve,
    solve_both_ways,
    solve_factorised,
)
from problems.rotor.response.model import impedances_of
from problems.rotor.response.receptance import FactoredShaft, shaft_motion
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


def test_kept_factors_give_each_solution_to_the_bit(matrices):
    """Elimination and substitutions are those of `solve`, in two calls of LAPACK."""
    rng = np.random.default_rng(2)
    force = rng.standard_normal((len(SPEED), len(matrices.mass), 3, 2)) @ [1, 1j]
    factors = factorised(dynamic_stiffness_band(matrices, SPEED))
    for part in (force, force[..., :1]):
        assert np.array_equal(solve_factorised(*factors, part), solve(dynamic_stiffness_band(matrices, SPEED), part))
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        none = np.zeros((8, 8))
        factorised(dynamic_stiffness_band(Matrices(none, none, none, none, none), SPEED[:2]))


@pytest.mark.parametrize("is_loaded", [False, True])
def test_a_factored_rotor_moves_as_one_that_is_solved_anew(is_loaded, monkeypatch):
    problem = ThreeDisk(mesh=13).build()
    impedances = impedances_of(problem.rotor, problem.unknowns)
    loads = unit_loads(problem.rotor, [Load(0.77, "x")], len(problem.speed)) if is_loaded else None
    factored = FactoredShaft.of(problem.rotor, impedances, problem.speed)
    expected = shaft_motion(problem.rotor, impedances, problem.speed, loads)
    assert np.array_equal(factored.under(loads).motion, expected.motion)
    monkeypatch.setattr(receptance, "MOST_KEPT", 100)
    assert FactoredShaft.of(problem.rotor, impedances, problem.speed) is None


def test_motion_and_adjoint_rows_agree_with_dense_ones(matrices):
    rng = np.random.default_rng(1)
    n_dof = len(matrices.mass)
    force = rng.standard_normal((len(SPEED), n_dof, 3, 2)) @ [1, 1j]
    rows = rng.standard_normal((4, n_dof))
    motion, seen = solve_both_ways(dynamic_stiffness_band(matrices, SPEED), force, rows)
    inverse = np.linalg.inv(dense.dynamic_stiffness(matrices, SPEED))
    for found, expected in ((motion, inverse @ force), (seen, rows @ inverse)):  # within rounding times the condition
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
