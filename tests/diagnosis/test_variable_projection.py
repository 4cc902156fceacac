"""Unbalance by least squares at points of all other unknowns: exact where the data have it, and a way to the best of many sweeps."""

import csv
import os
from pathlib import Path

import numpy as np
import pytest

from ksmea.diagnosis.exchange import exchanged
from ksmea.diagnosis.trials import best_by_name, candidates, fitted
from ksmea.fits.fitting import fit_baseline
from ksmea.fits.path_fits import fit_along
from ksmea.fits.search import Effort, Search
from ksmea.fits.variable_projection import linear_unknowns, projected, unbalance_planes
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from ksmea.units import DEGREE, MICROMETRE, RPM
from measurements.sweeps import speed_history
from problems.rk4_two_disk import RK4TwoDisk
from problems.three_disk import ThreeDisk

DATA = Path(os.environ.get("KSMEA_DATA", Path(__file__).parents[3] / "shared" / "data"))
RUN_UP = DATA / "rk4" / "runup_bode_first_critical.csv"


def test_unbalance_is_linear_in_pairs_of_magnitude_and_phase():
    two, one = RK4TwoDisk().build(), ThreeDisk().build()
    names = two.parameters.names
    pairs = [(names[magnitude], names[phase]) for magnitude, phase in unbalance_planes(two)]
    assert pairs == [("u1", "phase1"), ("u2", "phase2")]
    assert unbalance_planes(one) == []  # one plane: its factor and phase are set as such


def test_the_unbalance_of_the_data_is_met_exactly_at_their_supports():
    """From the dense route, at the true supports; at others the misfit is far from 0."""
    settings = RK4TwoDisk(sensors=[0.12, 0.44], n_speed=20)
    problem = settings.build()
    x = np.array([settings.reference()[name] for name in problem.parameters.names])
    measurement = Measurement(problem.speed, problem.channels, problem.dense_response(x[None])[0], None, "made")
    points = np.random.default_rng(0).random((5, len(x)))
    points[3, :4] = problem.parameters.to_cube(x)[:4]
    found = projected(Case(problem, measurement), Noise(0.05, 1e-7), unbalance_planes(problem), points)
    np.testing.assert_allclose(problem.parameters.to_si(found.points[0]), x, rtol=1e-6)
    assert found.misfits[0] < 1e-10 and found.misfits[1] > 1


def test_a_runout_is_linear_and_a_mass_is_not():
    problem = RK4TwoDisk(n_speed=5).build()
    for name, n_linear in (("runout", 2), ("residual_bow", 2), ("mass", 0)):
        extended = registry.create("effect", name, {}).locations(problem)[0].added_to(problem)
        d, e = len(problem.parameters), len(extended.parameters)
        assert len(linear_unknowns(extended, np.arange(d, e))) == n_linear, name


def run_up(layout, position):
    """The steady model and the published run-up of a real rig."""
    with RUN_UP.open() as file:
        speed, amplitude, phase = np.array([[float(value) for value in row.values()] for row in csv.DictReader(file)]).T
    values = (amplitude * MICROMETRE * np.exp(1j * DEGREE * phase))[:, None]
    history = speed_history(speed * RPM, None)
    measurement = Measurement(speed * RPM, (Channel(position, "x"),), values, None, "test", history=history)
    problem = RK4TwoDisk(layout=layout).build().at(measurement.speed, measurement.channels)
    return Case(problem, measurement)


@pytest.mark.slow
@pytest.mark.skipif(not RUN_UP.is_file(), reason=f"{RUN_UP} is not here: public data that are not committed")
def test_effects_on_a_real_run_up_end_at_the_best_maximum_of_their_neighbours():
    """Fits from nearby end at 112.6 for a thermal bow and 112.3 for a runout (ΔBIC); docs/rk4.md has these."""
    case, search = run_up("beam_model", 0.12), Search(np.random.default_rng(0))
    baseline = fit_baseline(case, search)
    names = ("thermal_bow", "runout", "residual_bow", "coupling_misalignment")
    effects = {name: registry.create("effect", name, {}).seen_in(case.measurement) for name in names}
    trials = fitted(baseline.best, candidates(case.problem, effects), search)
    trials = exchanged(trials, baseline, search)
    found = {name: trial.delta_bic for name, trial in best_by_name(trials).items()}
    assert found["thermal_bow"] == pytest.approx(129.0, abs=0.5)
    assert found["coupling_misalignment"] == pytest.approx(126.4, abs=0.5)
    assert found["runout"] == pytest.approx(117.7, abs=0.5)


@pytest.mark.slow
@pytest.mark.skipif(not RUN_UP.is_file(), reason=f"{RUN_UP} is not here: public data that are not committed")
@pytest.mark.parametrize(
    ("layout", "position", "drop", "rate"),
    [
        ("beam_model", 0.12, 189.9, 167.2),
        ("bearing_centres_560", 0.08, 146.4, 217.5),
    ],
)
def test_the_best_sweep_of_a_real_run_up_is_found_from_any_screening(layout, position, drop, rate):
    """The maxima of docs/rk4.md, with a quarter of the points and another scrambling. Fits of trials end some tenths of a standard error,
    9 rpm/s, from the maximum."""
    case = run_up(layout, position)
    baseline = fit_baseline(case, Search(np.random.default_rng(7)))
    sweep, _ = registry.create("effect", "run_up_acceleration", {}).locations(case.problem)
    extended = case.by(sweep.added_to(case.problem))
    fit = fit_along(extended, baseline, sweep.path(case.problem), Effort().of_first_scans)
    assert baseline.best.deviance - fit.deviance == pytest.approx(drop, abs=0.5)
    assert fit.x[-1] / RPM == pytest.approx(rate, abs=3.0)
