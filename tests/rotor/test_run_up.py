"""A sweep of the speed in closed form, against integration over time and what is known of a peak that is swept through."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.nonlinear.laws import LAWS, NonlinearLaw
from ksmea.plugins import registry
from problems.rk4_two_disk import RK4TwoDisk
from problems.rotor.extension.run_up import Sweep, parabola, sweep_change
from problems.rotor.extension.synchronous_poles import N_MODE, poles_on, spectrum, spectrum_of
from problems.rotor.finite_elements.assembly import Matrices
from problems.rotor.free_motion.stability import low_modes
from problems.rotor.response.dense import dynamic_stiffness
from swept_rotor import swept, swept_response
from tiers import mostly_slow

SPEED = np.linspace(85.0, 260.0, 176)
NONE = np.zeros((3, 3))
SPINNING = 0.1 * np.array([[0, 1, 0], [-1, 0, 0.5], [0, -0.5, 0]])  # N s/m per rad/s
UNBALANCE = np.array([1e-4, 2e-4j, -1e-4])  # kg m
SWEEP = 30.0  # rad/s², some times the squared half-width of each peak: steady states do not settle


def chain(gyroscopic=NONE):
    """Three masses on springs, with cross-coupling; critical speeds near 106, 175 and 203 rad/s, damping ratios 0.02 to 0.05."""
    stiffness = 1e4 * np.array([[3, -1, 0.03], [-1, 4, -2], [-0.03, -2, 5]])
    damping = 10 * np.array([[1, -0.3, 0], [-0.3, 1, 0], [0, 0, 2]])
    return Matrices(np.diag([1, 2, 1.5]), damping, gyroscopic, stiffness, NONE)


def closed_form(matrices, rate, speed=SPEED):
    """Steady and swept amplitudes, (n_speed, 3) each. On nominal springs at two of the masses there are other poles."""
    steady = np.linalg.solve(dynamic_stiffness(matrices, speed), (speed**2 * UNBALANCE[:, None]).T[..., None])[..., 0]
    sweep = Sweep(np.array([rate]), float(SPEED.max()))
    nominal = spectrum_of(matrices, np.eye(3)[:2], np.array([5e3 + 5e3j, 2e4]), np.eye(3), np.eye(3))
    none = np.zeros((3, 1, 2, 2), dtype=complex)
    poles = poles_on(nominal, none, parabola(sweep.nodes[:, None, None] ** 2 * UNBALANCE, sweep.nodes), sweep.reach)
    return steady, steady + sweep_change(poles, speed, sweep)[0]


def error(found, expected):
    return np.abs(found - expected).max() / np.abs(expected).max()


@pytest.mark.parametrize(("rate", "start"), [(SWEEP, 1.0), (-SWEEP, 400.0), (SWEEP / 2, 20.0)])
def test_a_rotor_with_constant_coefficients_responds_as_integrated(rate, start):
    """1e-6: the start is a little off, which dies out until the band; integration is ten times as exact."""
    _, found = closed_form(chain(), rate)
    assert error(found, swept(chain(), UNBALANCE, SPEED, rate, start)) < 1e-6


@pytest.mark.parametrize("rate", [SWEEP, -SWEEP])
def test_frequencies_that_the_speed_takes_along_leave_a_few_per_cent(rate):
    """Gyroscopic forces part frequencies by some per cent here; beats run out of step without the rate at which the speed gains
    on them. 2 % of the peak is what shapes and damping leave that change on the way."""
    steady, found = closed_form(chain(SPINNING), rate)
    expected = swept(chain(SPINNING), UNBALANCE, SPEED, rate, 1.0 if rate > 0 else 400.0)
    assert error(found, expected) < 0.02
    assert error(steady, expected) > 0.2


def test_the_slower_the_sweep_the_steadier():
    """The first term that a sweep adds is proportional to its rate."""
    steady, slow = closed_form(chain(), 1e-3)
    assert 0 < error(slow, steady) < 1e-3
    assert (closed_form(chain(), 2e-3)[1] - steady) == pytest.approx(2 * (slow - steady), rel=1e-2, abs=1e-14)


def test_the_peak_comes_late_lower_and_beats_behind_it():
    """The lowest critical speed, in the band up to where the next begins; behind a peak amplitudes fall and rise again."""
    steady, up = (np.abs(each[:, 0]) for each in closed_form(chain(), SWEEP, SPEED[:40]))
    down = np.abs(closed_form(chain(), -SWEEP, SPEED[:40])[1][:, 0])
    assert down.argmax() < steady.argmax() < up.argmax()
    assert max(up.max(), down.max()) < steady.max()
    assert np.any(np.diff(down[: down.argmax()]) < 0) and np.all(np.diff(steady[: steady.argmax()]) > 0)


def rk4(n_speed=60):
    """The two-disk rig with its reference values."""
    settings = RK4TwoDisk(n_speed=n_speed)
    problem = settings.build()
    return problem, np.array([settings.reference()[name] for name in problem.parameters.names])


def acceleration(problem, **settings):
    return registry.create("effect", "run_up_acceleration", settings).placed_on(problem)


@pytest.mark.parametrize("rate", mostly_slow([48.0, -48.0], but=[48.0]))
def test_a_rotor_on_its_bearings_responds_as_integrated(rate):
    """Gyroscopic forces are small in this rig: within 1 % of the peak, 0.6 % of which is for modes that the
    integration leaves out; the sweep changes a third of it."""
    problem, x = rk4()
    found = acceleration(problem).added_to(problem).response(np.append(x, rate)[None])[0]
    peak = np.abs(problem.response(x[None])).max()
    assert np.abs(found - swept_response(problem, x, rate)).max() < 0.01 * peak
    assert np.abs(found - problem.response(x[None])[0]).max() > 0.3 * peak


def test_a_mode_that_does_not_decay_is_left_as_it_is():
    """Cross-coupling beyond the stability threshold of the lowest mode: finite numbers, which no fit ends at."""
    problem, x = rk4()
    coupled = registry.create("effect", "cross_coupling_antisymmetric", {}).added_to(
        acceleration(problem).added_to(problem)
    )
    values = np.append(x, [24.0, 1e6])
    assert not coupled.is_stable(values)
    assert np.all(np.isfinite(coupled.response(values[None])))


def test_forces_that_are_not_linear_in_the_motion_have_no_modes():
    problem, _ = rk4()
    law = next(key for key, law in LAWS.items() if isinstance(law, NonlinearLaw))
    rub = registry.create("effect", "local_force", {"position": 0.16, "law": law})
    with pytest.raises(SettingError, match="expected forces that are linear in the motion together with a sweep"):
        acceleration(problem).added_to(rub.added_to(problem))


def test_run_up_and_coast_down_are_tried_apart_up_to_a_row_per_turn():
    """Rows of one turn each, as the speed rises at 24 rad/s²: Ω² rises by 4π α per row."""
    problem, _ = rk4()
    per_turn = np.sqrt(108.0**2 + 4 * np.pi * 24.0 * np.arange(170))
    up, down = registry.create("effect", "run_up_acceleration", {}).locations(problem.at(per_turn, problem.channels))
    assert (str(up), str(down)) == ("run-up", "coast-down")
    (rising,), (falling,) = up.parameters(problem), down.parameters(problem)
    assert (rising.lower, falling.upper) == (0.0, 0.0)
    assert (rising.upper, falling.lower) == pytest.approx((1.5 * 24.0, -1.5 * 24.0), rel=1e-6)
    one = problem.at(problem.speed[:1], problem.channels)
    assert registry.create("effect", "run_up_acceleration", {}).locations(one) == []


@pytest.mark.parametrize("seed", range(6))
def test_poles_are_those_of_the_whole_eigenproblem(seed):
    """Bearings anywhere within the limits, ten times off the nominal ones and more: poles near the measured speeds are those of
    the same matrices in one eigenproblem, within its rounding."""
    problem, _ = rk4()
    parameters = problem.parameters
    x = parameters.to_si(np.random.default_rng(seed).random(len(parameters)))
    highest = float(problem.speed.max())
    low = low_modes(problem.rotor, 1.5 * highest, (), N_MODE)
    stiffness, damping = (np.repeat([[x[at], x[at + 1]]], 2, axis=0).ravel() for at in (0, 2))
    added = low.ports.T @ (stiffness[:, None] * low.ports), low.ports.T @ (damping[:, None] * low.ports)
    matrices = dataclasses.replace(
        low.matrices, stiffness=low.matrices.stiffness + added[0], damping=low.matrices.damping + added[1]
    )
    whole = spectrum_of(matrices, low.ports, np.zeros(4), low.basis, low.basis.T).speed
    impedance = np.zeros((3, 1, 4, 4), dtype=complex)
    impedance[:2, 0] = np.diag(stiffness), 1j * np.diag(damping)
    nominal = spectrum(problem.rotor, 1.5 * highest, problem.channels)
    found = poles_on(nominal, impedance, np.zeros((3, 1, len(low.basis))), 2.5 * highest).speed[0]
    expected = whole[(np.abs(whole) < 1.2 * highest) & (np.abs(whole.real) > whole.imag)]
    assert len(expected) >= 2
    assert np.abs(found[:, None] - expected).min(axis=0).max() < 1e-7 * highest
