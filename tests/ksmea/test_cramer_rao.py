"""Fisher information and Cramér–Rao lower bounds: by a second route, in a closed case, and as the audit of the paper
has them."""

from pathlib import Path

import numpy as np
import pytest

import ksmea
from ksmea.inference.cramer_rao import Identifiability, identifiability
from ksmea.likelihood.fisher import whitened_sensitivity, with_prior_rows
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.problem.problem import joint_values
from problems.three_disk import ThreeDisk

TEN_PER_CENT = Noise(0.1, 0.0)


def truth(damping=1.0):
    """Reference values, the damping times a factor."""
    values = ThreeDisk().reference()
    return np.array([values[name] * (damping if name.startswith("c") else 1.0) for name in values])


def information(*arguments):
    whitened = whitened_sensitivity(*arguments)
    return whitened.T @ whitened


def crlb_pct(reading, kind, damping=1.0, **settings):
    wide = {"cxx": [0.01, 2000], "cyy": [0.01, 2000]}  # limits do not enter, but the nominal bearing does
    problem = ThreeDisk(reading=reading, limits=wide if damping > 1 else {}, **settings).build()
    return identifiability(problem, truth(damping), TEN_PER_CENT, kind).crlb_pct


SQRT2 = np.sqrt(
    2
)  # the printed CRLBs of complex data are for a noise of s per real and imaginary part; here it is s/√2


# 1-σ CRLBs in per cent for kxx, kyy, cxx, cyy, u: three-disk rotor, node 2, x and y, 10 % noise, as calculated
# independently, without what the variance tells (1 % here), and printed to the digits given: one or two digits allow
# 8 %, three or more 2 %.
@pytest.mark.parametrize(
    ("reading", "kind", "damping", "n_speed", "expected", "relative"),
    [
        ("rpm", "amplitude", 1, 53, [4145, 4949, np.nan, np.nan, 2159], 2e-2),
        ("rpm", "complex", 1, 53, [74, 89, 2560, 3080, 40], 2e-2),
        ("rad_s", "amplitude", 1, 53, [0.11, 0.11, 8.6, 21.5, 0.99], 5e-2),
        ("rad_s", "complex", 1, 53, [0.07, 0.09, 6.9, 8.9, 0.98], 8e-2),
        ("rad_s", "amplitude", 1000, 53, [27, 33, 4.0, 4.5, 1.2], 5e-2),
        ("rad_s", "complex", 1000, 53, [18, 22, 2.6, 3.1, 1.1], 5e-2),
        ("rad_s", "amplitude", 1, 27, [0.20, 0.25, 9.0, 66, 1.4], 5e-2),
    ],
    ids=["rpm", "rpm complex", "rad/s", "rad/s complex", "kN s/mm", "kN s/mm complex", "27 speeds"],
)
def test_the_crlb_of_the_papers_readings(reading, kind, damping, n_speed, expected, relative):
    found = crlb_pct(reading, kind, damping, n_speed=n_speed) * (SQRT2 if kind == "complex" else 1)
    known = ~np.isnan(expected)
    assert found[known] == pytest.approx(np.array(expected)[known], rel=relative)
    assert np.all(found[~known] > 1e5)  # in rpm amplitudes do not see the damping at all


def test_more_speeds_never_tell_less():
    few, many = crlb_pct("rad_s", "amplitude", n_speed=14), crlb_pct("rad_s", "amplitude", n_speed=27)
    assert np.all(many < few)  # every second of the 27 speeds is one of the 14


@pytest.mark.parametrize("kind", ["amplitude", "complex"])
def test_the_same_by_differences_of_the_dense_solver(kind):
    problem = ThreeDisk(n_speed=9).build()
    x = truth()
    noise = Noise(0.1, 1e-8)
    step = 1e-4 * x
    shifts = [
        problem.dense_response(np.array([x + sign * np.diag(step)[i] for i in range(5)])) for sign in (-2, -1, 1, 2)
    ]
    slope = np.moveaxis((shifts[0] - 8 * shifts[1] + 8 * shifts[2] - shifts[3]) / 12, 0, -1) / step
    response = problem.dense_response(x[None])[0]
    by_differences = information(response, slope, noise, Observable(kind))
    scale = np.outer(x, x)
    found = identifiability(problem, x, noise, kind).information * scale
    # fourth-order differences of a dense solution that is good to 1e-9 at these steps of 1e-4
    assert found == pytest.approx(by_differences * scale, rel=1e-4, abs=1e-4 * np.max(np.abs(found)))


def test_a_mean_measured_n_times_is_known_to_sigma_over_root_n():
    response = np.full((25, 1), 3.0 + 0j)
    slope = np.ones((25, 1, 1), dtype=complex)
    amplitude = information(response, slope, Noise(0.0, 0.5), Observable.AMPLITUDE)
    assert amplitude[0, 0] == pytest.approx(25 / 0.5**2)
    # a complex datum has half the variance in the direction of the change
    assert information(response, slope, Noise(0.0, 0.5), Observable.COMPLEX)[0, 0] == pytest.approx(2 * 25 / 0.5**2)


@pytest.mark.parametrize("observable", list(Observable))
def test_the_information_is_the_variance_of_the_score(observable):
    """By simulation: E[score²] over draws of ln p(y | x), its derivative taken by differences of the density."""
    rng, amplitude = np.random.default_rng(4), observable is Observable.AMPLITUDE
    noise, mean, slope = Noise(0.3, 0.1), 2.0 + 1.0j, 0.7 - 0.4j

    def log_density(y, theta):
        value = mean + slope * theta
        value = np.abs(value) if amplitude else value
        variance = noise.sd(np.abs(value)) ** 2
        return -(np.abs(y - value) ** 2) / (variance * (2 if amplitude else 1)) - np.log(variance) / (
            2 if amplitude else 1
        )

    sd = noise.sd(np.abs(mean))
    draws = rng.standard_normal((2, 200_000)) * sd
    y = np.abs(mean) + draws[0] if amplitude else mean + (draws[0] + 1j * draws[1]) / np.sqrt(2)
    score = (log_density(y, 1e-5) - log_density(y, -1e-5)) / 2e-5
    found = information(np.array([[mean]]), np.array([[[slope]]]), noise, observable)[0, 0]
    assert np.mean(score**2) == pytest.approx(found, rel=0.02)  # sampling error of a variance: √(2…4/200 000) ≈ 0.5 %


def test_unknowns_that_cannot_be_told_apart_have_no_crlb():
    response = np.array([[1.0 + 0j], [2.0 + 0j]])
    slope = np.stack([response, response, response**2], axis=-1)  # the first two act alike

    found = Identifiability(np.ones(3), whitened_sensitivity(response, slope, Noise(0.0, 0.1), Observable.AMPLITUDE))
    assert np.isinf(found.crlb[:2]).all() and np.isfinite(found.crlb[2])
    assert np.abs(found.worst_direction) == pytest.approx([np.sqrt(0.5), np.sqrt(0.5), 0], abs=1e-6)


def test_numbers_of_any_size_are_fitted_along(tmp_path):
    """In SI Young's modulus is 1e11 and a position 0.1: the bound is that of the inverse of the information in the unit cube."""
    path = tmp_path / "rotor.yaml"
    path.write_text(Path("docs/examples/rotor.yaml").read_text() + "\ntolerances: typical\n")
    rotor = ksmea.load_problem(str(path))
    joint = rotor.problem.joint
    response, slope = joint.linearised(joint_values(rotor.problem, joint, rotor.x()))
    rows = whitened_sensitivity(response, slope * joint.parameters.width, TEN_PER_CENT, Observable.AMPLITUDE)
    rows = with_prior_rows(rows, joint.parameters)
    expected = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows))) * joint.parameters.width
    found = identifiability(rotor.problem, rotor.x(), TEN_PER_CENT, "amplitude").crlb
    assert found == pytest.approx(expected[: len(found)], rel=1e-6)
