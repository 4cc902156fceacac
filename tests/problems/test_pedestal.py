"""A flexible pedestal in closed form: it is in series with its bearing."""

import dataclasses

import numpy as np
import pytest

from ksmea.plugins import registry
from ksmea.problem.parameters import Parameter
from problems.rotor.finite_elements.bearing import in_series
from problems.rotor.response.unknowns import BearingTarget, Unknown
from rigid_rotor import problem_of, rigid_rotor


def effect(name, **settings):
    return registry.create("effect", name, settings)


def random_impedance(n, n_speed):
    rng = np.random.default_rng(4)
    return 1e7 * (rng.standard_normal((2, 2, 2, n, n_speed)) + 1j * rng.standard_normal((2, 2, 2, n, n_speed)))


def on_pedestals(pedestal, impedance, speed, theta):
    return in_series(impedance, pedestal.support(theta).compliance(speed))


def test_a_rigid_pedestal_is_none_whatever_its_mass():
    impedance, speed = random_impedance(3, 5), np.linspace(100, 1500, 5)
    theta = np.array([[0, 0, 0, 0], [0, 0, 30, 0], [0, 0, 90.0, 0.1]])
    assert np.array_equal(on_pedestals(effect("flexible_pedestal"), impedance, speed, theta), impedance)


def test_a_pedestal_is_in_series_with_its_bearing():
    speed, loss = np.linspace(100, 1500, 5), np.array([[0.1], [0.03]])
    impedance, theta = random_impedance(2, 5), np.array([[3e-9, 8e-9, 20.0, 0.1], [1e-9, 0.0, 70.0, 0.03]])
    found = np.moveaxis(on_pedestals(effect("flexible_pedestal"), impedance, speed, theta), (1, 2), (-2, -1))
    compliance = [
        s / (1 + 1j * loss - s * theta[:, 2:3] * speed**2) for s in theta[:, :2].T[:, :, None]
    ]  # (n, n_speed)
    diagonal = np.stack(compliance, axis=-1)[..., None] * np.eye(2)
    expected = np.linalg.inv(np.linalg.inv(np.moveaxis(impedance, (1, 2), (-2, -1))) + diagonal)
    assert found == pytest.approx(expected, rel=1e-9)


def test_springs_in_series_add_their_compliances():
    pedestal = effect("flexible_pedestal", loss_factor=1e-12)
    impedance = np.zeros((1, 2, 2, 1, 1), dtype=complex)
    impedance[0, [0, 1], [0, 1]] = [[[5e7]], [[7e7]]]
    found = on_pedestals(pedestal, impedance, np.array([1e-3]), np.array([[1e-8, 2e-8, 50.0]]))
    assert found[0, 0, 0, 0, 0].real == pytest.approx(1 / (1 / 5e7 + 1e-8))
    assert found[0, 1, 1, 0, 0].real == pytest.approx(1 / (1 / 7e7 + 2e-8))


def test_the_softest_pedestal_is_that_of_physics_and_not_of_search_limits():
    """Weight presses it down by 0.2 mm, whatever stiffness the bearings may have; a loss factor that is known is no unknown."""
    limits = []
    for largest in (1e8, 1e12):
        stiffness = Unknown(Parameter("k", "N/m", 1.0, 1e5, largest), (BearingTarget(0, "kxx"),))
        problem = dataclasses.replace(problem_of(rigid_rotor(), np.array([100.0])), unknowns=(stiffness,))
        found = effect("flexible_pedestal").parameters(problem)
        assert [item.name for item in found][3:] == ["pedestal_loss_factor"]
        limits.append(found[0].upper)
        assert len(effect("flexible_pedestal", loss_factor=0.02).parameters(problem)) == 3
    weight = 9.80665 * problem.rotor.mass
    assert limits == [pytest.approx(0.2e-3 * 2 / weight)] * 2


def test_a_scan_takes_pedestals_that_resonate_within_the_speeds_or_up_to_twice_the_highest():
    problem = problem_of(rigid_rotor(), np.array([100.0, 300.0]))
    pedestal = effect("flexible_pedestal")
    values, items = pedestal.scan_further(problem), pedestal.parameters(problem)
    assert np.all((values > 0) & (values <= [item.upper for item in items]))
    assert np.ptp(values[:, 2]) > 4 * problem.rotor.mass
    inside = np.max(values[:, :2], axis=1) < items[0].upper  # softer ones are brought to the limit
    resonance = (values[:, 0] * values[:, 1]) ** -0.25 / np.sqrt(values[:, 2])
    assert np.all((resonance[inside] > 99) & (resonance[inside] < 601))
    assert np.sum(inside) > len(values) / 2
    assert effect("flexible_pedestal", loss_factor=0.02).scan_further(problem).shape == (len(values), 3)
