"""Too few data are refused, few are not tested, and what looks like a slip is told."""

import dataclasses

import numpy as np
import pytest

import ksmea
from ksmea.errors import SettingError
from ksmea.inference.intervals import Interval
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Layout, Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.problem.parameters import Parameter
from ksmea.show.identification_text import text
from ksmea.studies.enough_data import can_be_tested, estimate_record, n_real, require_enough
from ksmea.studies.misreadings import slips
from ksmea.units import RPM
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk()
PROBLEM = SETTINGS.build()
X = np.array([SETTINGS.reference()[name] for name in PROBLEM.parameters.names])
ONE = (Channel(0.1, "x"),)


def layout(n_speed, kind="complex"):
    return Layout(np.linspace(200, 1000, n_speed), ONE, kind, "run.csv")


def measured(speed, noise=None, kind="amplitude"):
    response = PROBLEM.at(np.asarray(speed), ONE).response(X[None])[0]
    return Measurement(
        np.asarray(speed), ONE, observe(response, kind, Noise(0.02, 1e-9), np.random.default_rng(1)), noise, "run.csv"
    )


def test_data_are_counted_as_real_numbers():
    assert (n_real(layout(3)), n_real(layout(3, "amplitude"))) == (6, 3)
    require_enough(layout(4), 6, with_noise=True)
    assert not can_be_tested(layout(7), 6, with_noise=True) and can_be_tested(layout(8), 6, with_noise=True)
    with pytest.raises(SettingError) as error:
        require_enough(layout(2), 6, with_noise=True)
    assert str(error.value) == (
        "run.csv: expected at least 8 data for 6 unknowns and 2 of the noise, got 4 (2 speeds × 1 channel × amplitude and"
        " phase); measure more speeds or channels, or state the noise (sigma_um)"
    )
    with pytest.raises(SettingError, match=r"at least 5 data for 5 unknowns, got 4 \(4 speeds × 1 channel\)"):
        require_enough(layout(4, "amplitude"), 5, with_noise=False)


def test_fewer_data_than_unknowns_are_refused():
    with pytest.raises(SettingError, match="expected at least 7 data for 5 unknowns and 2 of the noise, got 6"):
        ksmea.identify(PROBLEM, measured(np.linspace(300, 1200, 6)))


@pytest.mark.slow
def test_a_fit_of_hardly_more_data_is_not_called_an_explanation():
    few = ksmea.identify(PROBLEM, measured(np.linspace(300, 1200, 13)), "direct").record
    assert few.lack_of_fit is None and few.data.too_few_to_test
    assert text(few).splitlines()[-1].startswith("too few data to test the fit")
    assert "explains the data" not in text(few)
    enough = ksmea.identify(PROBLEM, measured(np.linspace(300, 1200, 14)), "direct").record
    assert enough.lack_of_fit is not None and "too few data" not in text(enough)


def test_a_band_that_holds_a_critical_speed_needs_no_remark():
    assert slips(Case.of(PROBLEM, measured(np.linspace(200, 1500, 20))), X) == ()
    assert (
        slips(Case.of(PROBLEM, measured(np.linspace(200, 300, 20))), X) == ()
    )  # the first critical, 379 rad/s, is within 30 %


def test_a_band_far_from_every_critical_speed_is_told():
    [remark] = slips(Case.of(PROBLEM, measured(np.linspace(100, 250, 20))), X)
    assert remark == (
        "no critical speed of the model lies inside the measured band or within 30 % of it (955 to 2387 rpm); the nearest"
        " one is at 3620 rpm"
    )
    found = ksmea.identify(PROBLEM, measured(np.linspace(100, 250, 20))).record
    assert found.data.remarks and f"  note: {found.data.remarks[0]}" in text(found).splitlines()


@pytest.mark.parametrize("factor, unit", [(60.0, "Hz"), (30 / np.pi, "rad/s")])
def test_speeds_in_another_unit_are_recognised(factor, unit):
    rpm = np.linspace(2000, 4000, 20) if unit == "Hz" else np.linspace(3000, 4300, 20)
    remarks = slips(Case.of(PROBLEM, measured(rpm / factor * RPM)), X)
    assert remarks[1:] == (
        f"speeds look like {unit}: {factor:.3g} times as high they enclose a critical speed; give them in rpm",
    )


def test_a_problem_that_does_not_know_its_modes_is_left_alone(monkeypatch):
    def refuses(*arguments):
        raise SettingError("expected a problem that knows its natural modes")

    far = measured(np.linspace(100, 250, 20))
    monkeypatch.setattr("problems.rotor.response.problem.critical_speeds", refuses)
    assert slips(Case.of(PROBLEM, far), X) == ()
    monkeypatch.undo()
    assert slips(Case.of(dataclasses.replace(PROBLEM), far), X) != ()
    assert slips(Case.of(ThreeDisk(mesh=100).build(), far), X) == ()  # too large to ask in passing


@pytest.mark.parametrize(
    ("value", "low", "high", "is_at_limit"),
    [(11.3, 6.4, 16.2, False), (3.0, 0.0, 8.0, True), (3.0, -np.inf, 8.0, True), (19990.0, 19980.0, np.inf, True)],
)
def test_a_small_value_of_a_wide_range_lies_on_no_limit_that_its_interval_does_not_reach(value, low, high, is_at_limit):
    damping = Parameter("seal_damping", "N s/m", 1.0, 0.0, 20e3)
    assert estimate_record(damping, value, Interval(low, high, "profile")).at_limit == is_at_limit
