"""Plans and identifiability of measured data: they say where the fitted model is rejected, and take noise that is stated datum
by datum to other speeds and probes."""

import dataclasses

import numpy as np
import pytest

import ksmea
from bench.reports.pages.made_by import command_line
from ksmea.fits.search import Effort, Search
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.studies import design_point
from ksmea.studies.design_point import DesignPoint, common_noise
from measurements.run_up_csv import as_csv

SHORT = ["problem.n_speed=27", "study.n_candidate=60", "workers=1"]


@pytest.fixture(scope="module")
def rotor():
    return ksmea.load_problem("three_disk", n_speed=27)


@pytest.fixture(scope="module")
def good(rotor):
    """Of the model itself, with noise stated datum by datum, as an exported measurement has it."""
    return with_sigma(ksmea.synthetic_measurement(rotor, relative=0.05, floor=0.02, kind="complex", rng=3).measurement)


@pytest.fixture(scope="module")
def bad(rotor):
    """Measurement with a runout that the model lacks."""
    hidden = {"hidden": ["runout"], "sizes": {"runout_x": 3.0, "runout_y": -4.0}}
    return with_sigma(ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", rng=3, **hidden).measurement)


def with_sigma(measurement):
    return dataclasses.replace(measurement, noise=Noise(0.0, measurement.noise.sd(np.abs(measurement.values))))


@pytest.fixture
def few_fits(monkeypatch):
    """A smaller search of the box: what is asked here does not hang on the best of all fits."""
    monkeypatch.setattr(design_point, "Search", lambda rng: Search(rng, Effort(screening=1000, starts=4)))


def test_one_noise_describes_what_is_stated_datum_by_datum(rotor, good, few_fits):
    point = DesignPoint.of_measurement(Case.of(rotor.problem, good), np.random.default_rng(0))
    # made of 5 % and 0.02 µm of the true response, and stated with the same of the measured one: exact
    assert (point.noise.relative, point.noise.floor) == pytest.approx((0.05, 2e-8), rel=1e-6)
    assert point.remarks == (
        "the noise is stated datum by datum: here it is 5 % of each value and 0.02 µm everywhere, which describes it best",
    )
    assert not point.lack_of_fit.rejected


def test_a_noise_without_one_of_its_parts_has_none_in_common():
    amplitude = np.array([[1e-6, 2e-6], [5e-6, 9e-6]])
    floor = common_noise(Noise(0.0, np.full((2, 2), 3e-7)), amplitude)
    relative = common_noise(Noise(0.0, 0.1 * amplitude), amplitude)
    assert (floor.relative, floor.floor) == (0.0, pytest.approx(3e-7))
    assert (relative.relative, relative.floor) == (pytest.approx(0.1), 0.0)


@pytest.mark.parametrize("amplitude", [[[0, 0, 1e-6], [0, 0, 2e-6]], np.zeros((2, 3))])
def test_readings_of_zero_have_a_noise_in_common(amplitude):
    """A constant noise is all floor, however many readings are 0."""
    found = common_noise(Noise(0.0, np.full((2, 3), 1e-7)), np.array(amplitude))
    assert (found.relative, found.floor) == (0.0, pytest.approx(1e-7))


def test_a_plan_of_a_fit_that_is_rejected_says_so(rotor, bad, few_fits):
    """By the same test as `identify`, in the text and in the record as JSON has it."""
    found = ksmea.plan(rotor, measurement=bad, add=2, sensors=0, trial_phases=[], n_candidate=20)
    assert ksmea.identify(rotor, bad).record.lack_of_fit.rejected
    told = found.record.to_data()["lack_of_fit"]
    assert told["rejected"] and told["p"] < 0.01 and told["statistic"]
    first = str(found).splitlines()[0]
    assert first.startswith("warning: the model does not fit: its residuals are not noise")
    assert "of a wrong model" in first and "+experiment=diagnose" in first
    assert type(found.record).from_data(found.record.to_data()) == found.record


def test_a_plan_of_nothing_measured_was_not_tested(rotor):
    found = ksmea.plan(rotor, relative=0.05, add=2, sensors=0, trial_phases=[], n_candidate=20)
    assert found.record.lack_of_fit is None and "warning" not in str(found)


@pytest.mark.parametrize("study", ["plan", "identifiability"])
def test_the_command_ends_with_the_diagnosis_to_run(study, bad, enter, tmp_path, few_fits):
    (tmp_path / "run.csv").write_text(as_csv(bad))
    own = ["study.add=2", "study.sensors=0", "study.trial_phases=[]"] if study == "plan" else ["study.variations=[]"]
    data = ["problem.n_speed=27", "measurement=file", "measurement.path=run.csv"]
    words = [*data, *own, *(SHORT[1:] if study == "plan" else SHORT[2:])]
    ended = enter(f"+experiment={study}", *words, output=f"results/{study}_run")
    assert ended.code == 0, ended.err
    assert "warning: the model does not fit" in ended.out
    diagnosis = command_line(["+experiment=diagnose", *data])
    assert diagnosis in ended.out
    page = (ended.output / "index.html").read_text()
    assert diagnosis in page and "diagnose it before you rely on this. With the model as it is: " in page
    assert ended.events()[0]["lack_of_fit"]["rejected"]
