"""A rotor that is measured while its speed sweeps: told from a steady one, and the rate found."""

import csv
import functools
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ksmea.diagnosis.diagnosis import diagnose
from ksmea.diagnosis.observability import collinearity
from ksmea.diagnosis.trials import candidates_and_left_out
from ksmea.fits.fitting import fit_baseline, fit_from_values, settled
from ksmea.fits.search import Effort, Search
from ksmea.measurement.campaign import Campaign, Run
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.speeds import SpeedHistory
from ksmea.plugins import registry
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.units import DEGREE, MICROMETRE, RPM
from measurements.sweeps import speed_history
from problems.rk4_two_disk import RK4TwoDisk
from swept_rotor import swept_response
from tiers import mostly_slow

ROOT = Path(__file__).parents[2]
RK4_RUN_UP = Path(os.environ.get("KSMEA_DATA", ROOT.parent / "shared/data")) / "rk4/runup_bode_first_critical.csv"
EFFECTS = ("run_up_acceleration", "speed_dependent_damping", "unbalance")
SETTINGS = RK4TwoDisk(sensors=[0.12, 0.44], directions=["x", "y"], n_speed=40)
LITTLE = Effort(screening=500, starts=4, scan=30, scan_values=8, effect_starts=2, average=False, split=False)
NOISE = Noise(0.05, 1e-7)


def diagnosed(rate, seed):
    """The diagnosis of data that are integrated over time, or steady."""
    problem = SETTINGS.build()
    values = observe(run(rate), "complex", NOISE, np.random.default_rng(seed))
    measurement = Measurement(problem.speed, problem.channels, values, None, "test")
    effects = {name: registry.create("effect", name, {}) for name in EFFECTS}
    return diagnose(Case(problem, measurement), effects, Search(np.random.default_rng(seed), LITTLE))


@pytest.mark.parametrize(
    ("rate", "direction", "seed"), mostly_slow([(24.0, "run-up", 0), (-15.0, "coast-down", 1)], but=[24.0])
)
def test_a_sweep_is_named_with_its_rate(rate, direction, seed):
    """Within the 95 % interval widened to twice its half-width: 99.99 %."""
    found = diagnosed(rate, seed)
    assert found.verdict == "named" and found.named == ("run_up_acceleration",)
    assert str(found.applied[0].effect) == direction
    interval = found.best_estimate.intervals[-1]
    assert abs(rate - (interval.low + interval.high) / 2) < interval.high - interval.low


@functools.cache
def run(rate):
    """The response of a run, integrated over time at its rate, or steady."""
    problem = SETTINGS.build()
    x = np.array([SETTINGS.reference()[name] for name in problem.parameters.names])
    return swept_response(problem, x, rate, n_mode=6) if rate else problem.dense_response(x[None])[0]


def two_runs(rates, directions, histories=(None, None)):
    """The true values and a measurement of two runs, integrated over time at their rates, or steady."""
    problem = SETTINGS.build()
    x = np.array([SETTINGS.reference()[name] for name in problem.parameters.names])
    runs = tuple(
        Run(f"run{number}", len(problem.speed), direction=direction, history=history)
        for number, (direction, history) in enumerate(zip(directions, histories))
    )
    values = observe(np.concatenate([run(rate) for rate in rates]), "complex", NOISE, np.random.default_rng(3))
    speed = np.tile(problem.speed, 2)
    return x, Measurement(speed, problem.channels, values, None, "test", campaign=Campaign(runs))


def test_a_rate_known_by_times_is_compared_with_another_effect_as_one_without_times():
    """Its prior is no change of the data."""
    histories = (SpeedHistory("run-up", (10.8, 12.0), True), SpeedHistory("coast-down", (-20.9, -20.3), True))
    cosines = []
    for known in (histories, (None, None)):
        x, measurement = two_runs((0.0, 0.0), ("up", "down"), known)
        case = Case(aligned(SETTINGS.build(), measurement), measurement)
        effects = {name: registry.create("effect", name, {}).seen_in(measurement) for name in EFFECTS}
        found, _ = candidates_and_left_out(case.problem.joint, effects)
        sweep, damping = ([each for each in found if each.name == name][-1] for name in EFFECTS[:2])
        fit = fit_from_values(case.by(damping.effect.added_to(case.problem)), np.append(x, 0.3))
        cosines.append(collinearity(SimpleNamespace(fit=fit, n_unknown=1), sweep))
    assert cosines[0] == pytest.approx(cosines[1], rel=1e-6) and 0 < cosines[0] < 1


@pytest.mark.xdist_group("runs up and down")
@pytest.mark.slow
@pytest.mark.parametrize("timed", [True, False])
def test_runs_up_and_down_have_rates_of_their_own(timed):
    """Both rates in their intervals widened to twice, 99.99 %; coefficients no less certain than from as many steady speeds, where
    rates add half of an interval at most. Times that are 2 to 4 % off are allowed for by their tolerance."""
    rates = (11.0, -20.0)
    histories = (SpeedHistory("run-up", (10.8, 12.0), True), SpeedHistory("coast-down", (-20.9, -20.3), True))
    x, measurement = two_runs(rates, ("up", "down"), histories if timed else (None, None))
    effects = {name: registry.create("effect", name, {}).seen_in(measurement) for name in EFFECTS}
    search = Search(np.random.default_rng(3), LITTLE)
    found = diagnose(Case(aligned(SETTINGS.build(), measurement), measurement), effects, search)
    assert found.verdict == "named" and found.named == ("run_up_acceleration",)
    assert str(found.applied[0].effect) == "runs up and down"
    intervals = np.array([(interval.low, interval.high) for interval in found.best_estimate.intervals])
    middle, width = intervals.mean(axis=1), np.ptp(intervals, axis=1)
    assert np.all(np.abs(middle - [*x, *rates]) < width)
    _, steady = two_runs((0.0, 0.0), ("steady", "steady"))
    fit = fit_baseline(Case(aligned(SETTINGS.build(), steady), steady), search).best
    of_steady = settled(fit, 0.95)[1].intervals
    assert np.all(width[:-2] < 1.5 * np.array([interval.high - interval.low for interval in of_steady]))


def test_steady_data_are_no_sweep():
    found = diagnosed(0.0, 2)
    assert found.verdict == "adequate" and found.named == ()


@pytest.mark.skipif(not RK4_RUN_UP.is_file(), reason=f"{RK4_RUN_UP} is not here: public data that are not committed")
def test_a_real_run_up_is_a_sweep_at_about_the_rate_that_its_rows_have():
    """Each row is a turn of the shaft, so that the rows themselves say the rate, which no fit sees: Ω² rises by 4π α per row.
    The fitted one is a quarter lower, as the model has neither runout nor a coupling of x and y; the noise is halved."""
    with RK4_RUN_UP.open() as file:
        speed, amplitude, phase = np.array([[float(value) for value in row.values()] for row in csv.DictReader(file)]).T
    values = (amplitude * MICROMETRE * np.exp(1j * DEGREE * phase))[:, None]
    measurement = Measurement(speed * RPM, (Channel(0.12, "x"),), values, None, "test")
    problem = RK4TwoDisk().build().at(measurement.speed, measurement.channels)
    steady = fit_baseline(Case(problem, measurement), Search(np.random.default_rng(0), LITTLE)).best
    (sweep, _) = registry.create("effect", "run_up_acceleration", {}).locations(problem)
    near = np.array([68e3, 82e3, 35.0, 23.0, 2.7e-6, -1.2, 0.5e-6, -4.4, 18.0])  # searched for by hand
    fit = fit_from_values(Case(sweep.added_to(problem), measurement), near)
    assert steady.deviance - fit.deviance > 150 and fit.noise.relative < steady.noise.relative / 2
    of_rows = speed_history(measurement.speed, None)
    assert of_rows.is_constant and not of_rows.from_times and 0.65 < fit.x[-1] / of_rows.rate < 1.05
