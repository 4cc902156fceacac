"""A rub that acts near resonances only: a scan of its limits misses it, and the force at its place tells it."""

import dataclasses
import functools

import numpy as np
import pytest

from ksmea.diagnosis.trials import Candidate, fitted, searched
from ksmea.fits.fitting import Fit, fit_baseline, least_deviance
from ksmea.fits.search import Effort, Search
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.location.force_start import can_recover, starts_from_force
from ksmea.location.law_start import nearest_start
from ksmea.location.location import fitted_site
from ksmea.location.unknown_force import Unmodelled
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.alignment import aligned, through
from ksmea.problem.case import Case
from ksmea.problem.load import FORCE
from measurements.synthetic import Synthetic
from problems.rk4_two_disk import RK4TwoDisk
from tiers import mostly_slow

LAYOUT = {"sensors": [0.12, 0.44], "directions": ["x", "y"], "n_speed": 24}
SETTINGS, FINE = RK4TwoDisk(**LAYOUT), RK4TwoDisk(**LAYOUT, mesh=56)
TRUTH = np.array([*SETTINGS.reference().values(), 0.4])  # the last is where phases begin
# stiffness N/m, clearance m, friction, by position m: peaks are larger than the clearance
RUB = {0.16: np.array([0.044e6, 19e-6, 0.05]), 0.4: np.array([0.08e6, 45e-6, 0.04])}
NOISE = Noise(0.05, 1e-7)
LITTLE = Effort(screening=500, starts=6)


@functools.cache
def rubbing(position, kind="complex", harmonics=()):
    """Two runs, the second with a known weight at 0.16 m, of a mesh four times as fine by the dense solver; the problem that is fitted
    to them, and the effect."""
    layout = Synthetic(
        kind=kind, floor=0.1, phase_known=False, runs=["bare", "3@0.16"], harmonics=list(harmonics)
    ).layout(SETTINGS)
    problem, effect = (
        aligned(SETTINGS.build(), layout),
        registry.create("effect", "clearance_rub", {"position": position}),
    )
    known = TRUTH[: len(problem.parameters)]
    response = effect.added_to(aligned(FINE.build(), layout)).dense_response(np.append(known, RUB[position])[None])[0]
    values = observe(response, kind, NOISE, np.random.default_rng(2))
    return (
        problem,
        Measurement(layout.speed, layout.channels, values, None, "test", layout.phase_known, layout.campaign),
        effect,
    )


@pytest.mark.slow
@pytest.mark.parametrize("position", mostly_slow([0.16, 0.4], but=[0.16]))
def test_a_law_is_near_its_coefficients_before_any_fit(position):
    """The unbalance at the place does not show beside a free force there, nor where phases begin if the weight is at it too: they are
    found together with the law. The shaft leaves the clearance by so little that its contact stiffness shows in few data."""
    problem, measurement, effect = rubbing(position)
    start = nearest_start(
        fitted_site(Case(problem, measurement), Unmodelled(FORCE, position), 16), effect.force_at()[1]
    )
    stiffness, clearance, _ = start.coefficients / RUB[position]
    assert 0.67 < stiffness < 1.5 and clearance == pytest.approx(1, abs=0.1)


@pytest.mark.slow
def test_a_rub_is_found_from_its_force_without_a_scan():
    """Its values within four standard errors, which leave one of 5000 right fits out."""
    problem, measurement, effect = rubbing(0.4)
    baseline = fit_baseline(Case(problem, measurement), Search(np.random.default_rng(0), LITTLE))
    (trial,) = fitted(baseline.best, [Candidate("clearance_rub", effect)], Search(np.random.default_rng(0), LITTLE))
    found = searched(trial, baseline, dataclasses.replace(LITTLE, is_scanned=False), 1)
    assert found.deviance_drop > 500
    errors = np.sqrt(np.diag(np.linalg.inv(found.fit.point.information)))[
        found.fit.likelihood.d - 3 : found.fit.likelihood.d
    ]
    limits = found.fit.problem.parameters
    reach = (limits.upper - limits.lower)[-3:]
    assert np.all(np.abs(found.fit.x[-3:] - RUB[0.4]) < 4 * errors * reach)


def test_what_tells_no_force_is_said():
    problem, measurement, effect = rubbing(0.4)
    assert can_recover(Case(problem, measurement), 0.4)
    assert not can_recover(
        Case(effect.added_to(problem), measurement), 0.4
    )  # under one that is not linear there are no unit loads
    assert not can_recover(Case(*rubbing(0.4, kind="amplitude")[:2]), 0.4)


def test_differences_between_runs_tell_no_free_force():
    problem, measurement, _ = rubbing(0.4)
    campaign = dataclasses.replace(measurement.campaign, reference=measurement.campaign.runs[0].name)
    assert not can_recover(Case.of(problem, dataclasses.replace(measurement, campaign=campaign)), 0.4)


@pytest.mark.slow
def test_a_fit_starts_where_the_law_explains_the_data():
    """One start, whose likelihood is that of the true values or higher; none where a free force is not enough."""
    problem, measurement, effect = rubbing(0.4)
    extended, known = effect.added_to(problem), TRUTH[: len(problem.parameters)]
    likelihood = likelihood_of(Case(extended, measurement))

    def deviance(u):
        return likelihood.deviance(likelihood.start(u))

    points = starts_from_force(Case(extended, measurement), Case(problem, measurement), *effect.force_at())
    truth = deviance(extended.parameters.to_cube(np.append(known, RUB[0.4])))
    assert len(points) == 1 and deviance(points[0]) < truth
    assert not len(
        starts_from_force(
            Case(extended, measurement), Case(problem, measurement), *effect.force_at(), ceiling=truth - 500
        )
    )


@pytest.mark.slow  # a rub is found from its force in the tests above
def test_a_hard_stop_whose_force_has_much_3x_is_found_in_a_run_up_and_one_down():
    """By 1X alone the law would fit this stop nowhere: the true values left a deviance 1700 higher."""
    layout = Synthetic(floor=0.1, phase_known=False, runs=["bare", "bare"], directions=["up", "down"]).layout(SETTINGS)
    problem, finer = (aligned(each.build(), layout) for each in (SETTINGS, FINE))
    stop = registry.create("effect", "clearance_rub", {"position": 0.4})
    large = np.where(np.isin(problem.parameters.names, ["u1", "u2"]), 4.0, 1.0) * TRUTH[: len(problem.parameters)]
    x = np.append(large, [0.26e6, 90e-6, 0.265])
    values = observe(stop.added_to(finer).response(x[None])[0], "complex", NOISE, np.random.default_rng(3))
    data = Measurement(layout.speed, layout.channels, values, None, "test", layout.phase_known, layout.campaign)
    extended = stop.added_to(problem)
    points = starts_from_force(Case(extended, data), Case(problem, data), *stop.force_at())
    assert extended.parameters.to_si(points[0])[-3:] == pytest.approx(x[-3:], rel=0.05)  # 5 % noise of 192 complex data


@pytest.mark.slow
def test_a_rub_moves_3x_and_explains_no_2x():
    """Forces alike in opposite directions have odd harmonics: 2X stays as it is. A stop may move 3X even if it is not touched as
    fitted."""
    problem, measurement, effect = rubbing(0.4, harmonics=(2.0, 3.0))
    of_harmonic = np.array([channel.harmonic for channel in measurement.channels])
    values = measurement.values.copy()
    values[:, of_harmonic == 2] += 5e-6
    data = dataclasses.replace(measurement, values=values)
    extended, known = effect.added_to(problem), TRUTH[: len(problem.parameters)]

    def fit_at(problem, x, data=data):
        likelihood = likelihood_of(Case(problem, data))
        return Fit(likelihood, likelihood.at(likelihood.start(problem.parameters.to_cube(x))))

    rub, untouched = fit_at(extended, np.append(known, RUB[0.4])), np.append(known, [0.08e6, 100e-6, 0.04])
    expected = rub.response().copy()
    assert np.any(expected[:, of_harmonic == 3] != 0) and not np.any(expected[:, of_harmonic == 2])
    for fit in (rub, fit_at(extended, untouched)):
        least = least_deviance(fit, rub, len(known))
        assert least == pytest.approx(rub.likelihood.deviance_of(expected), abs=1e-6)
    # what moves nothing there cannot explain 3X either, by as much as the rub does
    mass = registry.create("effect", "mass", {}).added_to(problem)
    expected[:, of_harmonic == 3] = 0
    linear = fit_at(mass, np.append(known, 0.0))
    assert least_deviance(linear, rub, len(known)) == pytest.approx(rub.likelihood.deviance_of(expected), abs=1e-6)
    at_rotation = data.through(np.flatnonzero(of_harmonic == 1).tolist())
    alone = fit_at(effect.added_to(through(problem, at_rotation.channels)), np.append(known, RUB[0.4]), at_rotation)
    assert np.isneginf(least_deviance(alone, alone, len(known)))


@pytest.mark.parametrize("own_noise", [False, True])
def test_the_noise_that_suits_a_response_best(own_noise):
    """A fit of the noise alone, all unknowns at their limits of a hair, ends at the same deviance."""
    problem, measurement, _ = rubbing(0.4)
    measurement = dataclasses.replace(
        measurement, campaign=dataclasses.replace(measurement.campaign, own_noise=own_noise)
    )
    problem = aligned(SETTINGS.build(), measurement.layout)
    likelihood = likelihood_of(Case(problem, measurement))
    u = problem.parameters.to_cube(TRUTH[: len(problem.parameters)])
    theta = likelihood.start(u)
    likelihood.lower[: likelihood.d], likelihood.upper[: likelihood.d] = u - 1e-12, u + 1e-12
    best = maximise(likelihood, theta)
    found = likelihood.deviance_of(problem.response(problem.parameters.to_si(u)[None])[0])
    assert found == pytest.approx(best.deviance, abs=1e-2)
