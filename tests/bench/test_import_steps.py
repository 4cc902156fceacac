"""Steps of rows between a file and a measurement: slow roll, sweeps, repeats, speeds of their own."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import ksmea
from bench import main
from instrument_files import SPEED, VALUES, system1, written
from ksmea.errors import SettingError
from measurements.file import File
from measurements.run_up_csv import as_csv

RUN_UP = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def own_file(rows, remarks=(), header=RUN_UP):
    Path("own.csv").write_text("\n".join([*remarks, header, *rows]) + "\n", encoding="utf-8")
    return "own.csv"


def test_slow_roll_is_subtracted_as_a_vector_and_once(folder):
    runout = np.array([2e-6 * np.exp(0.4j), 1e-6 * np.exp(2j)])
    slow, vectors = np.array([100.0, 120.0]), np.concatenate([np.zeros((2, 2)), VALUES]) + runout
    speeds = np.concatenate([slow, SPEED])
    measurement = dataclasses.replace(written(system1()).read(), speed=speeds * np.pi / 30, values=vectors, noise=None)
    Path("own.csv").write_text(as_csv(measurement), encoding="utf-8")
    assert main.run(["import", "own.csv", "--format", "run_up", "--slow-roll", "200", "--out", "run.csv"]) == 0
    data = ksmea.read_measurement("run.csv")
    assert data.values == pytest.approx(VALUES, rel=1e-6)  # eight printed digits of the sum
    assert "# slow roll: subtracted, the mean vector up to 200 rpm of x at 0.1 m 2 µm" in Path("run.csv").read_text(
        "utf-8"
    )
    with pytest.raises(SettingError, match="expected a file with slow roll in it"):
        File(path="run.csv", slow_roll=700.0)
    with pytest.raises(SettingError, match="expected a file with slow roll in it"):
        example = system1()
        written(
            dataclasses.replace(example, content=example.content.replace(b"Comp,", b"Comp,Slow Roll")), slow_roll=700.0
        )


@pytest.mark.parametrize(("highest", "is_near"), [(150.0, False), (340.0, True)])
def test_slow_roll_near_a_critical_speed_is_noted(folder, highest, is_near):
    """A rotor with its critical speed at 2000 rpm and 5 % damping: at 17 % of it 3 % of the eccentricity is motion, not runout."""
    speed = np.arange(100.0, 3000.0, 50.0)
    motion = 50 * (speed / 2000) ** 2 / np.abs(1 - (speed / 2000) ** 2 + 0.1j * speed / 2000)
    file = File(path=own_file([f"{a:g},0.1,x,{b:.4f},10" for a, b in zip(speed, motion)]), slow_roll=highest)
    [said] = file.remarks
    noted = f"{highest:g} rpm is 17 % of the first resonance in these data, 2000 rpm, where unbalance moves the shaft by up to 3.0 %"
    assert (noted in said) == is_near == ("give slow_roll below 300 rpm" in said)


def test_slow_roll_adds_its_variance(folder):
    rows = [f"{speed},0.1,x,{5 + speed / 1000},10,0.3" for speed in (100, 110, 120, 130, 1000, 1100, 1200)]
    file = File(path=own_file(rows, header=f"{RUN_UP},sigma_um"), slow_roll=200.0)
    # four rows of 0.3 µm have a mean of 0.15 µm
    assert file.noise.floor == pytest.approx(np.hypot(0.3, 0.15) * 1e-6)


def test_run_up_and_coast_down_are_told_apart(folder, capsys):
    up, down = SPEED, SPEED[::-1] + 3.7
    rows = [f"{speed},0.1,x,{2 + number},30" for number, part in enumerate((up, down)) for speed in part]
    example = own_file(rows)
    columns = ["speed=speed_rpm", "amplitude=amplitude_um_0pk", "phase=phase_lead_deg", "position=position_m"]
    answers = {"unit": "um", "amplitude": "0pk", "phase": "lead", "speed_unit": "rpm", "columns": columns}
    with pytest.raises(SettingError, match="give sweep=up or sweep=down"):
        File(path=example, format="csv", probes=["@0.1@x"], **{**answers, "columns": columns[:3]})
    for sweep, speeds, amplitude in (("up", up, 2e-6), ("down", np.sort(down), 3e-6)):
        data = File(path=example, sweep=sweep).read()
        # the turning point itself may count to either
        assert abs(len(data.speed) - len(speeds)) <= 1 and np.all(
            np.isin(np.round(data.speed * 30 / np.pi, 6), np.round(np.r_[up, down], 6))
        )
        assert np.count_nonzero(np.isclose(np.abs(data.values), amplitude)) >= len(speeds) - 1
    assert main.run(["import", example, "--format", "run_up", "--sweep", "both", "--out", "a, b #2.csv"]) == 0
    campaign = ksmea.read_measurement("a, b #2.yaml")
    assert [run.direction for run in campaign.campaign.runs] == ["up", "down"]
    assert len(campaign.speed) == len(rows)
    # runs of a second file have other names, so that both can be written into one campaign
    assert main.run(["import", example, "--format", "run_up", "--sweep", "both", "--out", "trial.csv"]) == 0
    first, second = (Path(name).read_text() for name in ("a, b #2.yaml", "trial.yaml"))
    Path("all.yaml").write_text(first + second.partition("runs:\n")[2])
    runs = ksmea.read_measurement("all.yaml").campaign.runs
    assert [run.name for run in runs] == ["a_b_2_up", "a_b_2_down", "trial_up", "trial_down"]


def test_repeated_speeds_are_averaged_where_that_is_asked_for(folder):
    rows = ["1000,0.1,x,2,0,0.2", "1000,0.1,x,2,90,0.2", "1100,0.1,x,3,0,0.2", "1200,0.1,x,3,0,0.2"]
    path = own_file(rows, header=f"{RUN_UP},sigma_um")
    with pytest.raises(SettingError, match=r"measurement\.repeats=average"):
        File(path=path)
    data = File(path=path, repeats="average").read()
    assert data.values[0, 0] == pytest.approx((2 + 2j) / 2 * 1e-6)
    assert data.noise.floor[:, 0] == pytest.approx(np.array([0.2 / np.sqrt(2), 0.2, 0.2]) * 1e-6)


def response_at(rpm):
    omega = rpm * np.pi / 30
    return 40.0 * omega**2 / (180.0**2 - omega**2 + 0.1j * 180.0 * omega)


def own_speeds(sigma=None):
    """Rows of a channel at even speeds and one at others, of the same response in µm."""
    rows = []
    for direction, speeds in (("x", np.arange(900.0, 2600.0, 20.0)), ("y", np.arange(911.0, 2580.0, 13.0))):
        for speed in speeds:
            value = response_at(speed)
            rows.append(
                f"{speed},0.1,{direction},{abs(value)},{np.angle(value, deg=True)}" + (f",{sigma}" if sigma else "")
            )
    return own_file(rows, header=RUN_UP + (",sigma_um" if sigma else ""))


def test_channels_with_speeds_of_their_own_are_interpolated(folder):
    path = own_speeds()
    with pytest.raises(SettingError, match="interpolate brings channels to common ones"):
        File(path=path)
    source = File(path=path, incomplete="interpolate")
    data = source.read()
    rpm = data.speed * 30 / np.pi
    # those of x, which has fewer rows, where y was measured too; near 1719 rpm they may be left out
    assert len(rpm) > 70 and np.allclose(rpm, 20 * np.round(rpm / 20))
    # what is stated of the error holds: 2 % of each vector
    assert np.max(np.abs(data.values[:, 1] * 1e6 / response_at(rpm) - 1)) < 0.02
    assert data.values[:, 0] * 1e6 == pytest.approx(response_at(rpm), rel=1e-9)
    assert "common speeds, from x at 0.1 m" in source.remarks[0]


def test_interpolation_states_its_uncertainty(folder):
    data = File(path=own_speeds(sigma=0.5), incomplete="interpolate").read()
    rpm, sigma = data.speed * 30 / np.pi, data.noise.floor * 1e6
    error = np.abs(data.values[:, 1] * 1e6 - response_at(rpm))
    assert sigma[:, 0] == pytest.approx(0.5)
    # between two rows of 0.5 µm: 0.5 at a row to 0.354 in the middle, and the error of interpolation where the curve bends
    far = np.abs(rpm - 1719) > 300
    assert np.all(sigma[far, 1] < 0.501) and np.min(sigma[:, 1]) == pytest.approx(0.5 / np.sqrt(2), rel=0.02)
    assert np.all(error < 3 * sigma[:, 1]) and np.max(sigma[:, 1]) > 0.5


def test_runs_at_speeds_of_their_own_are_interpolated_for_differences(folder):
    for name, speeds in (("bare", np.arange(900.0, 1500.0, 10.0)), ("trial", np.arange(903.0, 1480.0, 7.0))):
        rows = [f"{rpm},0.1,x,{abs(response_at(rpm))},{np.angle(response_at(rpm), deg=True)}" for rpm in speeds]
        Path(f"{name}.csv").write_text("\n".join([RUN_UP, *rows]), encoding="utf-8")
    Path("campaign.yaml").write_text("runs:\n  - {name: bare, file: bare.csv}\n  - {name: trial, file: trial.csv}\n")
    with pytest.raises(SettingError, match=r"measurement\.incomplete=interpolate"):
        rows = [f"{rpm},0.1,x,1,0" for rpm in (1503.0, 1515.0)]
        Path("far.csv").write_text("\n".join([RUN_UP, *rows]), encoding="utf-8")
        Path("far.yaml").write_text("runs:\n  - {name: bare, file: bare.csv}\n  - {name: far, file: far.csv}\n")
        ksmea.read_measurement("far.yaml", reference="bare")
    few = ksmea.read_measurement("campaign.yaml", reference="bare")
    data = ksmea.read_measurement("campaign.yaml", reference="bare", incomplete="interpolate")
    rpm = data.speed * 30 / np.pi
    assert len(data.speed) > 2 * len(few.speed)
    assert np.max(np.abs(data.values[:, 0] * 1e6 / response_at(rpm) - 1)) < 0.02  # as is stated
    bare, trial = (rpm[rows] for rows in data.rows)
    assert np.array_equal(bare, trial)


def of_units(folder, phase="deg", sigma="mil pp", time="s"):
    turn = {"rad": np.pi / 180}.get(phase, 1.0)
    lines = [f"n (rpm),A (mil pp),P ({phase}),S ({sigma}),t ({time})"]
    lines += [f"{1000 + 100 * row},{2 + row},{30 * turn},0.02,{10 * row}" for row in range(5)]
    (folder / "units.csv").write_text("\n".join(lines), encoding="utf-8")
    columns = ["speed=#1", "amplitude.A=#2", "phase.A=#3", "sigma.A=#4", "time=#5"]
    return File(path="units.csv", format="csv", probes=["A@0.1@x"], phase="lead", columns=columns)


def test_phases_and_times_are_in_the_unit_that_the_table_says(folder):
    plain = of_units(folder)
    assert of_units(folder, phase="rad").read().values == pytest.approx(plain.read().values, rel=1e-12)
    assert of_units(folder, time="ms").time == pytest.approx(plain.time / 1000)


@pytest.mark.parametrize("case", [{"sigma": "um pp"}, {"sigma": "mil 0pk"}, {"time": "furlongs"}])
def test_units_that_are_not_those_of_the_amplitude_or_of_a_time_are_refused(folder, case):
    with pytest.raises(SettingError, match=r"unit of #2|expected a time"):
        of_units(folder, **case)
