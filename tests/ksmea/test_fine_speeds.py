"""Speeds that a model is drawn at: no peak is cut off, few speeds where nothing happens, runs apart."""

import numpy as np
import pytest

from ksmea import diagnose, load_problem, read_measurement, synthetic_measurement
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.show.charts.responses import ACCEPTED
from ksmea.show.diagnosis_text import diagnosis_chart
from ksmea.studies.curves import MOST, fine_curve, fine_layout

ROTOR = load_problem("three_disk")


@pytest.fixture(scope="module")
def measured():
    return synthetic_measurement(ROTOR, relative=0.05, kind="complex", rng=1).measurement


def test_no_peak_is_cut_off(measured):
    problem = aligned(ROTOR.problem, measured)
    curve = fine_curve(Case(problem, measured), ROTOR.x())
    drawn = np.array(curve.amplitude)
    assert len(measured.speed) < len(curve.speed) < MOST
    for critical in ROTOR.critical_speeds():
        near = critical + np.linspace(-1.0, 1.0, 401)  # steps of a thirtieth of the half-width
        peak = np.abs(problem.at(near, problem.channels).response(ROTOR.x()[None])[0]).max(axis=0)
        shown = drawn[np.abs(np.array(curve.speed) - critical) < 1.0].max(axis=0)
        assert np.all(shown > 0.9 * peak)  # lines are straight within 6 %; even speeds show half of it
    assert np.max(np.abs(measured.values)) < 0.5 * drawn.max()  # the measured speeds alone cut them off


def test_measured_speeds_are_among_them_and_runs_stay_apart():
    measured = read_measurement("docs/examples/campaign.yaml")
    problem = aligned(load_problem("docs/examples/rotor.yaml").problem, measured)
    x = (problem.parameters.lower + problem.parameters.upper) / 2
    layout = fine_layout(measured, [(problem, x)])
    assert len(layout.rows) == len(measured.rows) > 1
    for finer, own in zip(layout.rows, measured.rows):
        speed = layout.speed[finer]
        assert np.all(np.diff(speed) > 0) and np.all(np.isin(measured.speed[own], speed))
        assert speed[0] == measured.speed[own].min() and speed[-1] == measured.speed[own].max()
    assert aligned(problem, layout).response(x[None]).shape[1] == len(layout.speed)


def test_a_smooth_response_takes_the_even_speeds_alone():
    quiet = load_problem("three_disk", reading="rpm")  # far below the first critical speed
    measured = synthetic_measurement(quiet, relative=0.05, rng=1).measurement
    assert len(fine_layout(measured, [(aligned(quiet.problem, measured), quiet.x())]).speed) < 160


def test_a_diagnosis_shows_its_models_where_they_have_peaks_and_older_records_as_they_were(measured):
    found = diagnose(ROTOR, measured, effects=["none"], blocks=2, locate=False, starts=4).record
    curve = found.curves.fine_before
    assert len(curve.speed) > len(measured.speed) and curve.phase is not None
    first, *others = diagnosis_chart(found).panels
    assert len(line_of(first).x) == len(curve.speed)
    assert any("phase" in panel.y.label for panel in others)
    older = found.to_data()
    del older["curves"]["fine_before"], older["curves"]["fine_after"]
    first, *_ = diagnosis_chart(DiagnosisRecord.from_data(older)).panels
    assert len(line_of(first).x) == len(measured.speed)


def line_of(panel):
    [line] = [each for each in panel.elements if each.name == ACCEPTED]
    return line
