"""Unbalance by least squares at points of all other unknowns: exact where the data have it, and a way to the best of many sweeps."""

import csv
import os
from pathlib import Path

import numpy as np
import pytest

from ksmea.fits.fitting import fit_baseline
from ksmea.fits.path_fits import fit_along
from ksmea.fits.search import Effort, Search
from ksmea.fits.variable_projection import projected, unbalance_planes
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from ksmea.units import DEGREE, MICROMETRE, RPM
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


@pytest.mark.skipif(not RUN_UP.is_file(), reason=f"{RUN_UP} is not here: public data that are not committed")
@pytest.mark.parametrize(
    ("layout", "position", "drop", "rate"),
    [("beam_model", 0.12, 189.9, 167.2), ("bearing_centres_560", 0.08, 146.4, 217.5)],
)
def test_the_best_sweep_of_a_real_run_up_is_found_from_any_screening(layout, position, drop, rate):
    """The maxima of docs/rk4.md, with a quarter of the points and another scrambling. Fits of trials end some tenths of a standard error,
    9 rpm/s, from the maximum."""
    with RUN_UP.open() as file:
        speed, amplitude, phase = np.array([[float(value) for value in row.values()] for row in csv.DictReader(file)]).T
    values = (amplitude * MICROMETRE * np.exp(1j * DEGREE * phase))[:, None]
    measurement = Measurement(speed * RPM, (Channel(position, "x"),), values, None, "test")
    problem = RK4TwoDisk(layout=layout).build().at(measurement.speed, measurement.channels)
    baseline = fit_baseline(Case(problem, measurement), Search(np.random.default_rng(7)))
    sweep, _ = registry.create("effect", "run_up_acceleration", {}).locations(problem)
    case = Case(sweep.added_to(problem), measurement)
    fit = fit_along(case, baseline, sweep.path(problem), Effort().of_first_scans)
    assert baseline.best.deviance - fit.deviance == pytest.approx(drop, abs=0.5)
    assert fit.x[-1] / RPM == pytest.approx(rate, abs=3.0)
