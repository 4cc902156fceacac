"""Data at 2X and 3X beside 1X: files, what is refused, and that they do not disturb what they tell nothing of."""

import dataclasses

import numpy as np
import pytest

import ksmea
from ksmea.errors import SettingError
from ksmea.fits.starts import screened
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.numerics.screening import sobol
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from measurements.campaign import CampaignFile
from measurements.file import File
from measurements.run_up_csv import as_csv
from problems.three_disk import ThreeDisk

CHANNELS = (Channel(0.1, "x"), Channel(0.1, "y"), Channel(0.1, "x", 2.0), Channel(0.1, "y", 0.5))


def synthetic(**settings):
    rotor = ksmea.load_problem("three_disk")
    known = {"relative": 0.05, "floor": 0.1, "kind": "complex", "noise_known": False, "harmonics": [2.0], **settings}
    return rotor, ksmea.synthetic_measurement(rotor, **known)


def test_synthetic_data_have_every_probe_at_every_harmonic():
    """A right model has noise alone there: the floor's. 106 complex values tell its size within 7 % (1 σ); 4 σ."""
    _, data = synthetic(harmonics=[2.0, 3.0])
    values, channels = data.measurement.values, data.measurement.channels
    assert [channel.harmonic for channel in channels] == [1, 1, 2, 2, 3, 3]
    assert np.sqrt(np.mean(np.abs(values[:, 2:4]) ** 2)) == pytest.approx(1e-7, rel=0.28)
    assert np.abs(values[:, :2]).min() > 0


def test_a_file_with_harmonics_goes_there_and_back(tmp_path):
    _, data = synthetic()
    file = tmp_path / "run.csv"
    file.write_text(as_csv(data.measurement))
    back = File(str(file)).read()
    assert back.channels == data.measurement.channels
    assert back.values == pytest.approx(data.measurement.values, rel=1e-7)  # eight digits


def test_an_empty_harmonic_is_1x_and_a_column_without_others_is_not_written(tmp_path):
    file = tmp_path / "run.csv"
    rows = ["1000,0.1,x,10,30,,", "1000,0.1,x,1,10,,2", "2000,0.1,x,20,40,,1", "2000,0.1,x,2,-10,,2.0"]
    header = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg,sigma_um,harmonic"
    file.write_text("\n".join([header, *rows]))
    found = File(str(file)).read()
    assert found.channels == (Channel(0.1, "x"), Channel(0.1, "x", 2.0))
    assert "harmonic" not in as_csv(found.through([0])) and "harmonic" in as_csv(found)


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ("1000,0.1,x,10,30,0", "line 3: expected harmonic above 0"),
        ("1000,0.1,x,10,30,second", "line 3: expected a number for harmonic"),
        ("1000,0.1,x,10,30,1", "expected each speed and channel once"),
    ],
)
def test_a_harmonic_that_is_none_is_refused_with_its_line(tmp_path, cells, message):
    file = tmp_path / "run.csv"
    header = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg,harmonic"
    file.write_text(f"{header}\n1000,0.1,x,10,30,1\n{cells}")
    with pytest.raises(SettingError, match=message):
        File(str(file))


def test_amplitudes_alone_are_refused_beside_1x(tmp_path):
    """Of noise alone an amplitude is never 0. Gaussian amplitudes would take its mean for a response: with |y| of standard
    normal y, mean √(2/π) and variance 1 − 2/π, a constant lowers the deviance by −ln(1 − 2/π) = 1.01 for each datum."""
    file = tmp_path / "run.csv"
    file.write_text(
        "speed_rpm,position_m,direction,amplitude_um_0pk,harmonic\n1000,0.1,x,9,1\n1000,0.1,x,1,2\n2000,0.1,x,9,1\n2000,0.1,x,1,2\n"
    )
    with pytest.raises(SettingError, match=r"line 3: expected phases .* with 2X x at 0.1 m"):
        File(str(file))
    with pytest.raises(SettingError, match=r"expected phases with 2X x at 0\.1 m"):
        Measurement(np.ones(3), CHANNELS[::2], np.ones((3, 2)), None, "test")
    with pytest.raises(SettingError, match="harmonics: expected kind=complex"):
        synthetic(kind="amplitude")
    with pytest.raises(SettingError, match="and a floor above 0"):
        synthetic(floor=0.0)
    noise = np.abs(np.random.default_rng(0).standard_normal(100_000))
    assert np.log(np.mean(noise**2) / np.var(noise)) == pytest.approx(1.01, abs=0.02)


def test_data_without_1x_are_refused():
    with pytest.raises(SettingError, match="expected 1X with 2X"):
        Measurement(np.ones(3), CHANNELS[2:3], np.ones((3, 1), complex), None, "test")


@pytest.mark.slow
def test_identification_is_the_one_of_1x_alone():
    """Whatever stands at 2X: a model that has no response there learns nothing of it, nor of its noise."""
    rotor, data = synthetic()
    loud = data.measurement.values * [1, 1, 1e3, 1e3]
    whole = ksmea.identify(rotor, dataclasses.replace(data.measurement, values=loud), rng=1)
    alone = ksmea.identify(rotor, data.measurement.through([0, 1]), rng=1)
    assert [part.identified for part in whole.record.parameters] == [
        part.identified for part in alone.record.parameters
    ]
    assert "2X x at 0.1 m, 2X y at 0.1 m" in str(whole)


def test_screening_finds_the_same_points_whatever_stands_at_2x():
    """A response of 0 has no logarithm: misfits are finite, and 2X adds the same to each point."""
    rotor, data = synthetic()
    problem = aligned(rotor.problem, data.measurement)
    points = sobol(256, len(problem.parameters))
    both = screened(Case(problem, data.measurement), points)
    alone = screened(Case(problem, data.measurement).at_1x(), points)
    assert np.isfinite(both.misfits).all()
    assert both.points == pytest.approx(alone.points)
    # half of the data are at 1X; what the others add is the same for all
    added = both.misfits - alone.misfits / 2
    assert added == pytest.approx(np.full(256, added[0]), rel=1e-9)


def test_channels_that_a_problem_answers_are_kept():
    problem = ThreeDisk(n_speed=3).build()
    seen = problem.at(problem.speed, CHANNELS)
    data = Measurement(
        problem.speed, CHANNELS, np.ones((3, 4), complex), Noise(0.0, np.ones((3, 4)) * [1, 2, 3, 4]), "test"
    )
    case = Case(seen, data).answered()
    part, kept = case.problem, case.measurement
    assert part.channels == kept.channels == CHANNELS[:2]
    assert np.array_equal(kept.noise.floor, np.ones((3, 2)) * [1, 2])


def test_runs_of_a_campaign_may_hold_harmonics(tmp_path):
    """Both files come back with their channels, and balancing is of 1X: influence coefficients are of a force at it."""
    _, data = synthetic(runs=["bare", "150@1"])
    measurement = data.measurement
    lines = ["runs:"]
    for run, rows, weight in zip("ab", measurement.rows, ["", "{position: 1, g_mm: 150}"], strict=True):
        part = dataclasses.replace(measurement.part(np.arange(rows.start, rows.stop)), campaign=None)
        (tmp_path / f"{run}.csv").write_text(as_csv(part))
        lines.append(f"  - {{name: {run}, file: {run}.csv, weights: [{weight}]}}")
    (tmp_path / "campaign.yaml").write_text("\n".join(lines))
    back = CampaignFile(str(tmp_path / "campaign.yaml")).read()
    assert back.channels == measurement.channels
    assert back.values == pytest.approx(measurement.values, rel=1e-7)
    entries = {entry.channel for entry in ksmea.balance(back).record.entries}
    assert entries == {"x at 0.1 m", "y at 0.1 m"}
