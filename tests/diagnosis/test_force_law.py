"""Laws of an unknown force: the one that acts is found with its size, others leave more than the free force does."""

import dataclasses

import numpy as np
import pytest

from ksmea.location.force_law import LawLikelihood, _fitted, _trials, fitted_laws
from ksmea.location.law_start import law_starts
from ksmea.location.location import locate
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.nonlinear.laws import LAWS
from ksmea.problem.case import Case
from ksmea.problem.load import Load
from problems.rotor.finite_elements.assembly import assemble
from problems.rotor.finite_elements.data import UnbalancePlane
from problems.rotor.finite_elements.loads import complex_unbalance, force_per_unbalance, unit_loads
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.response import dense
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk
from tiers import mostly_slow

TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
PROBLEM = ThreeDisk(sensors=[0.1, 0.5, 1.0], n_speed=40).build()
FINE = ThreeDisk(mesh=26, sensors=[0.1, 0.5, 1.0], n_speed=40).build()
ROTOR = rotor_at(FINE.rotor, FINE.unknowns, TRUTH)
FIRST, LAST = ROTOR.bearings
BY_NAME = {law.name: law for law in LAWS.values()}

HIDDEN = {  # law, where, the rotor that hides it, and the sizes of its coefficients, SI
    "unbalance, ∝ Ω²": (
        1.0,
        dataclasses.replace(ROTOR, unbalance=(*ROTOR.unbalance, UnbalancePlane(1.0, 6e-5, np.pi / 3))),
        6e-5 * np.array([np.cos(np.pi / 3), np.sin(np.pi / 3)]),
    ),
    "mass": (1.0, dataclasses.replace(ROTOR, disks=(*ROTOR.disks, Disk(1.0, 8.0, 1e-6, 1e-6))), np.array([8.0])),
    "spring": (
        0.0,
        dataclasses.replace(
            ROTOR, bearings=(dataclasses.replace(FIRST, kxx=FIRST.kxx + 9e6, kyy=FIRST.kyy + 6e6), LAST)
        ),
        np.array([9e6, 6e6]),
    ),
    "damper": (
        0.0,
        dataclasses.replace(
            ROTOR, bearings=(dataclasses.replace(FIRST, cxx=FIRST.cxx + 8e3, cyy=FIRST.cyy + 6e3), LAST)
        ),
        np.array([8e3, 6e3]),
    ),
    "cross-coupling": (
        1.3,
        dataclasses.replace(ROTOR, bearings=(FIRST, dataclasses.replace(LAST, kxy=6e6, kyx=-6e6))),
        np.array([6e6]),
    ),
}


OMEGA = FINE.speed[:, None, None]
SWIRL = np.array([[0.0, 1.0], [-1.0, 0.0]])
CARRIED = 3.0 * (600.0**2 + 2j * 0.03 * 600.0 * OMEGA)  # spring and damper of a mass of 3 kg
FOLLOWS_SPEED = 4e3 * FINE.speed  # N/m
BY_MATRICES = {  # law, quantity, load (n_speed, 2) of its own, impedance (n_speed, 2, 2) to the motion of its site, sizes
    "spring_proportional_to_speed": ("force", 0, FOLLOWS_SPEED[:, None, None] * np.diag([1.0, 1.5]), [4e3, 6e3]),
    "proportional_to_speed": ("force", (0.03 + 0.02j) * FINE.speed[:, None] * [1, -1j], 0, [0.03, 0.02]),
    "seal": ("force", 0, (2e6 + 4e3j * OMEGA) * np.eye(2) + 2e3 * OMEGA * SWIRL, [2e6, 4e3, 2e3]),
    "cross_coupled_spring_and_damper": (
        "force",
        0,
        (2e6 + 4e3j * OMEGA) * np.eye(2) + (3e6 - 1e3j * OMEGA) * SWIRL,
        [2e6, 3e6, 4e3, -1e3],
    ),
    # the spring in series with the mass, K⁻¹ = (k + iΩc)⁻¹ + (−m Ω²)⁻¹
    "spring_mass": ("force", 0, np.eye(2) / (1 / CARRIED - 1 / (3.0 * OMEGA**2)), [3.0, 600.0, 0.03]),
    "skew": ("moment", (2e-5 - 1e-5j) * FINE.speed[:, None] ** 2 * [1, -1j], 0, [2e-5, -1e-5]),
    "moment_proportional_to_speed": ("moment", 0.01 * FINE.speed[:, None] * [1, -1j], 0, [0.01, 0.0]),
}


@pytest.mark.parametrize("key", mostly_slow(BY_MATRICES, but=list(BY_MATRICES)[:2]))
def test_a_law_put_into_the_matrices_is_found_with_its_size(key):
    quantity, load, impedance, sizes = BY_MATRICES[key]
    at_site = unit_loads(ROTOR, [Load(1.0, axis, quantity) for axis in "xy"], len(FINE.speed))
    stiffness = dense.dynamic_stiffness(assemble(ROTOR), FINE.speed)
    stiffness = stiffness + at_site @ (impedance + np.zeros((2, 2))) @ np.swapaxes(at_site, 1, 2)
    force = force_per_unbalance(ROTOR, FINE.speed) @ complex_unbalance(ROTOR)
    force = force + (at_site @ (load + np.zeros((len(FINE.speed), 2)))[..., None])[..., 0]
    response = np.linalg.solve(stiffness, force[..., None])[..., 0] @ dense.channel_rows(ROTOR, FINE.channels).T
    values = observe(response, "complex", Noise(0.05, 1e-7), np.random.default_rng(len(key)))
    data = Measurement(PROBLEM.speed, PROBLEM.channels, values, None, "test")
    found = locate(Case(PROBLEM, data), np.random.default_rng(0), positions=[1.0], quantities=[quantity])
    best = fitted_laws(found.sites, found.noise)[0]
    assert best.law.key == key
    assert best.p > 0.001  # one draw each
    assert np.all(np.abs(best.values - sizes) < 4 * best.sd)
    units = [size for _, _, size in best.law.coefficients]
    assert np.all(best.sd / units < 0.3 * np.abs(np.array(sizes) / units).max())


@pytest.fixture(scope="module")
def site_of():
    """The fit of an unknown force where a law acts, in data of another route and twice as many elements."""
    found = {}

    def call(name):
        if name not in found:
            position, rotor, _ = HIDDEN[name]
            response = dense.dense_response(rotor, FINE.speed, FINE.channels)
            values = observe(response, "complex", Noise(0.05, 1e-7), np.random.default_rng(len(name)))
            data = Measurement(PROBLEM.speed, PROBLEM.channels, values, None, "test")
            found[name] = locate(
                Case(PROBLEM, data), np.random.default_rng(0), positions=[position], quantities=["force"]
            )
        return found[name].sites[0], found[name].noise

    return call


@pytest.mark.parametrize("name", mostly_slow(HIDDEN, but=list(HIDDEN)[:2]))
def test_the_law_that_acts_is_found_with_its_size(name, site_of):
    best = fitted_laws([site_of(name)[0]], site_of(name)[1])[0]
    assert best.law.name == name
    assert best.p > 0.001  # one draw each
    assert np.all(np.abs(best.values - HIDDEN[name][2]) < 4 * best.sd)
    assert np.all(best.sd < 0.5 * np.abs(HIDDEN[name][2]).max())


def test_laws_are_sought_along_the_shaft_from_where_one_is_best(monkeypatch):
    """Tried first two elements away, as happens where that leaves less beside a free force. Each site is prepared once."""
    position, rotor, _ = HIDDEN["mass"]
    response = dense.dense_response(rotor, FINE.speed, FINE.channels)
    values = observe(response, "complex", Noise(0.05, 1e-7), np.random.default_rng(4))
    data = Measurement(PROBLEM.speed, PROBLEM.channels, values, None, "test")
    positions = [0.8, 0.9, position]
    found = locate(Case(PROBLEM, data), np.random.default_rng(0), positions=positions, quantities=["force"])
    prepared = []

    def law_starts_of(site, laws):
        prepared.append(site.unmodelled.position)
        return law_starts(site, laws)

    monkeypatch.setattr("ksmea.location.force_law.N_FIRST", 1)
    monkeypatch.setattr("ksmea.location.force_law.law_starts", law_starts_of)
    best = fitted_laws(found.sites, found.noise)[0]
    assert (best.law.name, best.site.unmodelled.position) == ("mass", position)
    assert sorted(prepared) == positions


def fitted_law(site, law, noise):
    """One law at a site, without a comparison with others."""
    [trial] = _trials(site, [law])
    return _fitted(trial, noise)


@pytest.mark.parametrize("name, wrong", [("unbalance, ∝ Ω²", "constant, turning with the shaft"), ("mass", "spring")])
def test_another_law_leaves_more_than_the_free_force(name, wrong, site_of):
    site, noise = site_of(name)
    assert fitted_law(site, BY_NAME[wrong], noise).p < 1e-6


def test_a_law_that_holds_another_one_is_as_near_and_costs_more(site_of):
    site, noise = site_of("mass")
    narrow, wide = (fitted_law(site, BY_NAME[name], noise) for name in ("mass", "spring, damper and mass"))
    assert wide.p > 0.001 and wide.bic > narrow.bic
    assert np.all(np.abs(wide.values[:4]) < 4 * wide.sd[:4])  # neither spring nor damper


def test_the_gradient_is_that_of_the_deviance(site_of):
    site, _ = site_of("spring")
    likelihood = LawLikelihood(site, BY_NAME["spring"], np.array([1e6, 1e6]))
    theta = np.append(site.point.theta * 0.9 + 0.05, [7.0, 5.0])
    step = 1e-6 * np.eye(len(theta))
    differences = [(likelihood.deviance(theta + each) - likelihood.deviance(theta - each)) / 2e-6 for each in step]
    # differences of differences: 1e-4 of the largest slope
    gradient = likelihood.at(theta).gradient
    np.testing.assert_allclose(gradient, differences, rtol=1e-3, atol=1e-4 * np.abs(gradient).max())
