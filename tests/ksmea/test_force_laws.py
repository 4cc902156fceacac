"""Laws of a force by closed forms, quadrature and the equation that they solve."""

import numpy as np
import pytest

from ksmea.nonlinear.harmonic_balance import Balance, Harmonics
from ksmea.nonlinear.laws import LAWS, NonlinearLaw
from ksmea.nonlinear.steady_motion import SiteMotion
from ksmea.numerics.differences import central_differences

RNG = np.random.default_rng(4)
MOTION = 1e-4 * (RNG.standard_normal((3, 5, 2)) + 1j * RNG.standard_normal((3, 5, 2)))
SPEED = np.linspace(100.0, 500.0, 5)
SIZES = {  # SI
    "rotating_asymmetry": [2e6, -1e6],
    "cubic_spring": [3e15],
    "spring_above_an_amplitude": [4e6, 6e-5],
    "rub": [4e6, 6e-5, 0.3],
}
COEFFICIENTS = {key: np.tile(sizes, (3, 1)) for key, sizes in SIZES.items()}


def at_frequency_of_rotation(force_at, motion, n_angle=20_000):
    """(1/π) ∫ F e^{−iφ} dφ over one turn of the orbit Re(q e^{iφ}), by the midpoint rule."""
    turn = np.exp(2j * np.pi * (np.arange(n_angle) + 0.5) / n_angle)
    orbit = (motion[..., None, :] * turn[:, None]).real
    return 2 * np.mean(force_at(orbit, turn) * turn.conj()[:, None], axis=-2)


def asymmetric(orbit, turn):
    """−Δ (r along the stiff axis, less r across it), the axis at half the angle of κ and turning with the shaft."""
    delta, angle = 1e6 * np.hypot(2, -1), np.angle(2 - 1j) / 2
    axis = np.stack([(turn * np.exp(1j * angle)).real, (turn * np.exp(1j * angle)).imag], axis=-1)
    return -delta * (2 * np.sum(orbit * axis, axis=-1, keepdims=True) * axis - orbit)


def cubic(orbit, turn):
    return -3e15 * np.sum(orbit**2, axis=-1, keepdims=True) * orbit


def beyond(orbit, turn):
    radius = np.linalg.norm(orbit, axis=-1, keepdims=True)
    return -4e6 * np.maximum(1 - 6e-5 / radius, 0) * orbit


def rubbing(orbit, turn):
    normal = beyond(orbit, turn)
    return normal + 0.3 * np.stack([-normal[..., 1], normal[..., 0]], axis=-1)


ON_ORBIT = {
    "rotating_asymmetry": asymmetric,
    "cubic_spring": cubic,
    "spring_above_an_amplitude": beyond,
    "rub": rubbing,
}


@pytest.mark.parametrize("key", ON_ORBIT)
def test_the_part_at_the_frequency_of_rotation_is_that_of_the_force_on_the_orbit(key):
    expected = at_frequency_of_rotation(ON_ORBIT[key], MOTION)
    found = LAWS[key].at_motion(COEFFICIENTS[key], SPEED, MOTION)
    # sums over angles are exact of polynomials; of a force with a kink 64 of half a turn are to a few thousandths of the largest
    tolerance = 1e-9 if key in ("rotating_asymmetry", "cubic_spring") else 3e-3
    np.testing.assert_allclose(found, expected, atol=tolerance * np.abs(expected).max())


def test_friction_drives_backward_and_an_asymmetry_answers_forward_whirl_alone():
    forward, backward = (np.tile(np.array([1, sign * 1j]) * 1e-4, (3, 5, 1)) for sign in (-1, 1))
    force = LAWS["rub"].at_motion(COEFFICIENTS["rub"], SPEED, forward)
    work = np.pi * np.sum((forward.conj() * force).imag, axis=-1)
    assert np.all(work < 0)  # of the friction against a shaft that turns and whirls forward
    asymmetry = [
        LAWS["rotating_asymmetry"].at_motion(COEFFICIENTS["rotating_asymmetry"], SPEED, each)
        for each in (forward, backward)
    ]
    assert np.abs(asymmetry[1]).max() < 1e-12 * np.abs(asymmetry[0]).max()


@pytest.mark.parametrize("orders", [(1,), (1, 3, 5), (1, 0, 2)])
@pytest.mark.parametrize("key", SIZES)
def test_derivatives_are_those_of_differences(key, orders):
    harmonics = Harmonics(orders)
    q = np.stack([MOTION[0, 0] * 0.3**index for index in range(len(orders))])
    at = harmonics.components(q[None])[0] / 1e-4

    def acting(components):  # (n, p), in units of 1e-4 m
        none = np.zeros_like(components)
        coefficients = np.tile(SIZES[key], (len(components), 1))
        return Balance(LAWS[key].on_orbit, coefficients, harmonics, none, none[..., None]).acting(1e-4 * components)

    differences = central_differences(at, 1e-6, at - 1, at + 1)
    by_parts = differences.derivative(acting(differences.points)[0]) / 1e-4
    expected = acting(at[None])[1][0]
    np.testing.assert_allclose(by_parts, expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("key", [key for key, law in LAWS.items() if law.follows_motion])
def test_what_acts_goes_with_the_motion_that_it_makes(key):
    """q = Q + G f(q), with a site that a force moves far more than it would be moved without."""
    law = LAWS[key]
    sizes = SIZES.get(key, [0.3 * size for _, _, size in law.coefficients])
    coefficients = np.tile(sizes, (3, 1))
    per_force = 2e-8 * (RNG.standard_normal((3, 5, 2, 2)) + 1j * RNG.standard_normal((3, 5, 2, 2)))
    per_force = per_force + np.eye(2) * 1e-7
    force = law.steady(coefficients, SiteMotion(SPEED, MOTION, per_force))
    moved = MOTION + (per_force @ force[..., None])[..., 0]
    np.testing.assert_allclose(law.at_motion(coefficients, SPEED, moved), force, rtol=1e-6, atol=1e-6)


def test_one_that_is_linear_in_the_motion_is_solved_exactly():
    """A stop without clearance is a spring."""
    per_force = np.broadcast_to(np.eye(2) * (1e-7 - 2e-8j), (3, 5, 2, 2))
    spring = LAWS["spring"].steady(np.full((3, 2), 4e6), SiteMotion(SPEED, MOTION, per_force))
    stop = LAWS["spring_above_an_amplitude"].steady(np.tile([4e6, 0.0], (3, 1)), SiteMotion(SPEED, MOTION, per_force))
    np.testing.assert_allclose(stop, spring, rtol=1e-9)


def test_nothing_acts_inside_of_the_clearance():
    per_force = np.broadcast_to(np.eye(2, dtype=complex) * 1e-7, (3, 5, 2, 2))
    force = LAWS["rub"].steady(np.tile([4e6, 1e-2, 0.3], (3, 1)), SiteMotion(SPEED, MOTION, per_force))
    assert np.all(force == 0)


def test_where_no_motion_is_steady_it_says_so():
    """A spring of −1/G takes all stiffness away; powers of two have no rounding. A stop of −1/G on a motion along a line of
    amplitude a leaves a (1 − N(a)), with the describing function N of a dead zone δ: less than 4 δ/π for any a."""
    per_force = np.broadcast_to(np.eye(2, dtype=complex) / 2**23, (3, 5, 2, 2))
    with pytest.raises(np.linalg.LinAlgError):
        LAWS["spring"].steady(np.full((3, 2), -(2.0**23)), SiteMotion(SPEED, MOTION, per_force))
    line, along = np.tile([1e-4, 0j], (3, 5, 1)), per_force * np.diag([1, 0])
    with pytest.raises(np.linalg.LinAlgError, match="no steady motion"):
        LAWS["spring_above_an_amplitude"].steady(np.tile([-(2.0**23), 3e-5], (3, 1)), SiteMotion(SPEED, line, along))


def test_every_nonlinear_law_is_tested_here():
    assert {key for key, law in LAWS.items() if isinstance(law, NonlinearLaw)} == set(SIZES)
