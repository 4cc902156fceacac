"""Identification from a measured file, whose truth only the tests know: made by the dense route on a finer mesh."""

import csv
import dataclasses
import os
import shlex
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from bench.jobs.records import RecordWriter
from bench.plan.plan import read_plan
from bench.plan.report import report_named
from bench.reports.runs import of_identifications, runs_frame
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.records.identification import IdentificationRecord, LackOfFit, ParameterRecord, Seconds
from ksmea.show.charts.responses import residuals_of_fit
from ksmea.show.identification_text import text
from ksmea.show.text import fit_verdict
from ksmea.units import MICROMETRE, RPM
from measurements.file import File
from measurements.run_up_csv import as_csv
from problems.three_disk import ThreeDisk
from tiers import mostly_slow

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "docs/examples/run_up.csv"
RK4_RUN_UP = Path(os.environ.get("KSMEA_DATA", ROOT.parent / "shared/data")) / "rk4/runup_bode_first_critical.csv"
IDENTIFY = ["+experiment=identify", "workers=1"]
CHEAP = ["optimizer.screening=100", "optimizer.starts=1", "study.intervals=none"]
TRUTH = ThreeDisk().reference()
UNITS = {"kxx": 1e6, "kyy": 1e6, "cxx": 1e3, "cyy": 1e3, "u": 1e-6}

EXAMPLE_REMARKS = (
    "A run-up of the rotor of problem=three_disk, invented: 90 speeds, probes in x and y at 0.1 m, one row per speed and",
    "channel in the order of time. Made by tests/bench/test_identify_file.py with the reference values (kxx 50 MN/m, kyy",
    "70 MN/m, cxx 0.5 kN s/m, cyy 0.7 kN s/m, u 200 g mm) on a mesh of 52 elements by the dense solver; 5 % + 0.02 µm noise",
    "(sigma_um is empty: unknown); all phases turned by 40 deg, as by a keyphasor mark that sits anywhere.",
    "Units: rpm; m from the left end; µm zero to peak; degrees of phase LEAD (an instrument's lag: change the sign); s.",
)


def run_up(
    kind="complex", *, seed=2013, n_speed=90, relative=0.05, floor=0.02, turn=40.0, probes=((0.1, "x"), (0.1, "y"))
):
    """A measurement of known truth at uneven speeds of a run-up, and when each was passed (s)."""
    rng = np.random.default_rng(seed)
    time = np.round(np.sort(rng.uniform(0, 60, n_speed)), 2)
    speed = np.round(2000 + 12000 * (time / 60) ** 1.2, 1) * RPM
    channels = tuple(Channel(*probe) for probe in probes)
    response = dense_response(tuple(speed), channels) * np.exp(1j * np.radians(turn))
    values = observe(response, kind, Noise(relative, floor * MICROMETRE), rng)
    return Measurement(speed, channels, values, None, "made"), time


@cache
def dense_response(speed, channels):
    """The response at the reference values on another mesh than the fit's, by one solve with the whole rotor a speed."""
    problem = ThreeDisk(mesh=52).build().at(np.array(speed), channels)
    return problem.dense_response(np.array([[TRUTH[name] for name in problem.parameters.names]]))[0]


def example_text():
    measurement, time = run_up()
    return as_csv(measurement, EXAMPLE_REMARKS, time)


def table_of(ended):
    return ended.table("identify").set_index("parameter")


def covers(table, name, value):
    row = table.loc[name]
    return not (row["low"] > value or row["high"] < value)


def test_the_example_is_what_its_remarks_say(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("again.csv").write_text(example_text(), encoding="utf-8")
    example, again = File(path=str(EXAMPLE)), File(path="again.csv")
    assert example.measure(None, {}, None, None).values == pytest.approx(
        again.measure(None, {}, None, None).values, rel=1e-6
    )
    assert example.time == pytest.approx(again.time)
    assert EXAMPLE.read_text(encoding="utf-8").splitlines()[:6] == example_text().splitlines()[:6]


@pytest.fixture(scope="module")
def example(apart, tmp_path_factory):
    """The identification of the example, as the documentation gives the command."""
    cwd = tmp_path_factory.mktemp("example")
    words = ["problem=three_disk", "measurement=file", f"measurement.path={EXAMPLE}"]
    return apart("+experiment=identify", *words, draws=True, cwd=cwd, output="results/identify_run_up")


def test_the_truth_lies_in_the_intervals(example):
    assert example.code == 0, example.err
    table = table_of(example)
    assert list(table.index) == [*UNITS, "phase_origin"]
    for name, unit in UNITS.items():
        assert covers(table, name, TRUTH[name] / unit), table.loc[name]
        assert table.loc[name, "kind"] in ("gauss-newton", "profile") and not table.loc[name, "at_limit"]
        half_width = (table.loc[name, "high"] - table.loc[name, "low"]) / 2
        assert half_width == pytest.approx(1.96 * table.loc[name, "crlb"], rel=0.1)
    assert covers(table, "phase_origin", 40.0) and table.loc["phase_origin", "high"] < 42


def test_what_is_printed_can_be_read(example):
    lines = example.out.splitlines()
    assert lines[0] == (
        "three_disk, run_up.csv: 90 speeds from 2062 to 13868 rpm, 2 channels (x at 0.1 m, y at 0.1 m), amplitudes (0-peak) and phases"
    )
    assert any(line.startswith("  kxx = 50.0") and " MN/m, 95 % interval [49.9" in line for line in lines)
    assert any(line.startswith(("  phase_origin = 39.8", "  phase_origin = 39.9")) for line in lines)
    assert "noise, estimated: 5.2 % + 0.018 µm" in lines
    assert "strongly correlated parameters (|r| > 0.95): none" in lines
    assert {"identify.csv", "identify.png", "runs.csv"} <= {path.name for path in example.output.iterdir()}


def test_the_record_holds_what_the_report_shows(example):
    (record,) = map(IdentificationRecord.from_data, example.events())
    assert all(parameter.true is None for parameter in record.parameters)
    scaled = np.concatenate([part for index in range(2) for part in residuals_of_fit(record.fit, index)])
    assert np.std(scaled) == pytest.approx(1, abs=0.15)  # 360 residuals in units of their noise
    runs = example.runs()
    assert (runs["kxx_search_end_error_pct"] == "").all() and (runs["kxx_covered"] == "").all()
    assert example.cells()[0]["parameters"][0]["truth"] is None


def test_runs_csv_tells_the_reported_value_from_where_the_search_ended(plan, tmp_path):
    part = ParameterRecord("kxx", "MN/m", 1e6, 47.4e6, False, 50e6, 48.4e6, 49.2e6, "profile", most_likely=48.8e6)
    alone = dataclasses.replace(part, low=None, high=None, kind=None, most_likely=None)
    with RecordWriter(tmp_path, 0, plan) as writer:
        for run, each in zip(plan.runs, (part, alone)):
            found = IdentificationRecord("done", "", (each,), 1.0, 0, 1, 0, 0, Seconds())
            writer.result(run, {"status": "done", **found.to_data()})
    runs = of_identifications(plan, tmp_path)
    assert runs.loc[:1, ["kxx_value", "kxx_search_end"]].to_numpy().tolist() == [[48.8, 47.4], [47.4, 47.4]]
    assert runs.loc[0, "kxx_search_end_error_pct"] == pytest.approx(-5.2)  # 47.4 beside 50
    assert not {"kxx", "kxx_most_likely", "kxx_error_pct"} & set(runs.columns)  # no name that could mean either
    assert runs_frame(plan, tmp_path)["kxx"].tolist()[:2] == [47.4, 47.4]  # what tables of methods compare


def test_a_summary_without_truth_has_no_errors(example, enter):
    cheap = ["optimizer.screening=200", "optimizer.starts=2", "method=direct", "optimizer=lm", "repetitions=2"]
    ended = enter(*cheap, "measurement=file", f"measurement.path={EXAMPLE}", "workers=1")
    assert ended.code == 0, ended.err
    table = ended.table("run").set_index("parameter")
    assert table[["reference", "error_pct_median", "covered_pct"]].isna().all(axis=None)
    assert table.loc["kxx":"phase_origin", "crlb_pct"].notna().all()
    line = next(line for line in ended.out.splitlines() if line.split()[:1] == ["kxx"])
    assert line.split()[2] == "–" and "[" in line


@pytest.fixture
def identified(enter, tmp_path):
    """Identification from a made measurement."""

    def call(measurement, *words):
        (tmp_path / "run.csv").write_text(as_csv(measurement))
        ended = enter(*IDENTIFY, "measurement.path=run.csv", *words, output="results/identify_run")
        assert ended.code == 0, ended.err + ended.out
        return ended

    return call


def test_amplitudes_of_one_channel_at_uneven_speeds_are_enough_for_the_stiffness(identified):
    measurement, _ = run_up("amplitude", n_speed=40, probes=[(0.1, "x")])
    ended = identified(measurement)
    table = table_of(ended)
    assert list(table.index) == list(UNITS)  # no phase, no phase origin
    for name, unit in UNITS.items():
        assert covers(table, name, TRUTH[name] / unit), table.loc[name]
    assert table.loc["kxx", "high"] - table.loc["kxx", "low"] < 2
    assert "cxx: not identifiable from these data" in ended.out  # no speed lies on a peak


@pytest.mark.parametrize("turn", mostly_slow([-175.0, 0.0, 100.0, 179.9], but=[179.9]))
def test_the_phase_origin_is_found_wherever_it_is(identified, turn):
    measurement, _ = run_up(turn=turn, n_speed=60, relative=0.02)
    table = table_of(identified(measurement, "optimizer.starts=5"))
    value, low, high = table.loc["phase_origin", ["value", "low", "high"]].astype(float)
    assert -180 < value <= 180 and low < value < high and high - low < 2
    assert abs((value - turn + 180) % 360 - 180) < high - low
    assert not table.loc["phase_origin", "at_limit"]


@pytest.mark.slow
def test_known_noise_is_not_estimated(identified):
    measurement, _ = run_up(n_speed=60)
    noise = Noise(0.0, np.hypot(0.05 * np.abs(measurement.values), 0.02 * MICROMETRE))
    ended = identified(Measurement(measurement.speed, measurement.channels, measurement.values, noise, "made"))
    table = table_of(ended)
    for name, unit in UNITS.items():
        # sd from the noisy values leans towards small responses: a little more than the interval
        value, low, high = table.loc[name, ["value", "low", "high"]].astype(float)
        assert abs(value - TRUTH[name] / unit) < 1.5 * (high - low) / 2
    assert "noise as stated datum by datum: " in ended.out


@pytest.mark.slow
def test_phases_given_as_lag_are_noticed(identified):
    measurement, _ = run_up(n_speed=40)
    ended = identified(dataclasses.replace(measurement, values=measurement.values.conj()), "optimizer.starts=5")
    remark = "the data look as if phases are lags where leads are expected: read so, the fit leaves"
    (record,) = map(IdentificationRecord.from_data, ended.events())
    assert [said[: len(remark)] for said in record.data.remarks] == [remark]
    assert ended.out.count(f"  note: {remark}") == ended.out.count("lags") == 1


@pytest.mark.slow
def test_a_changed_file_is_another_question(enter, tmp_path):
    measurement, _ = run_up(n_speed=20)
    cheap = [*IDENTIFY, "measurement.path=run.csv", *CHEAP]
    (tmp_path / "run.csv").write_text(as_csv(measurement))
    first = set(enter(*cheap, output="results/identify_run").runs()["key"])
    assert len(enter(*cheap, output="results/identify_run").events()) == 1  # nothing is done again
    (tmp_path / "run.csv").write_text(as_csv(measurement, ["a remark"]))
    changed = enter(*cheap, output="results/identify_run")
    assert changed.code == 0 and len(changed.events()) == 2 and first.isdisjoint(changed.runs()["key"])
    assert "measurement_fingerprint" in changed.cells()[0]["settings"]


@pytest.mark.slow
def test_a_pipe_that_closes_early_is_no_error(tmp_path):
    measurement, _ = run_up(n_speed=20)
    (tmp_path / "run.csv").write_text(as_csv(measurement))
    settings = " ".join(["measurement.path=run.csv", *CHEAP])
    words = f"{shlex.quote(sys.executable)} -m bench +experiment=identify {settings}"
    done = subprocess.run(
        f"{words} | head -1", shell=True, check=False, cwd=tmp_path, capture_output=True, text=True, timeout=100
    )
    assert done.stdout.startswith("three_disk, run.csv: 20 speeds") and "Traceback" not in done.stderr


@pytest.mark.slow
def test_several_runs_have_a_block_each(enter, tmp_path):
    measurement, _ = run_up(n_speed=20)
    (tmp_path / "run.csv").write_text(as_csv(measurement))
    words = [*CHEAP, "problem.mesh=13,21", "repetitions=3"]
    ended = enter(*IDENTIFY, "measurement.path=run.csv", *words, output="results/identify_run")
    assert ended.code == 0, ended.err
    assert "three_disk, run.csv, problem.mesh 13, repetition 0: 20 speeds" in ended.out
    assert "and 2 more in identify.csv" in ended.out
    assert len(ended.table("identify")) == 6 * 6 and (ended.output / "identify_4.png").is_file()


def test_synthetic_data_can_be_reported_alike(enter):
    cheap = ["optimizer.screening=200", "optimizer.starts=2"]
    ended = enter(*IDENTIFY, "measurement=synthetic", "measurement.relative=0.1", *cheap, output="results/identify")
    assert ended.code == 0, ended.err
    assert "three_disk, synthetic: 53 speeds" in ended.out and "noise as stated: 10 %" in ended.out


def test_without_noise_there_are_values_alone(enter):
    cheap = ["optimizer.screening=200", "optimizer.starts=2"]
    ended = enter(*IDENTIFY, "measurement=synthetic", *cheap, output="results/identify")
    assert ended.code == 0 and "interval [" not in ended.out and "not computed, without noise" in ended.out


def test_a_run_that_fails_says_so(enter, tmp_path):
    measurement, _ = run_up(n_speed=20)
    (tmp_path / "run.csv").write_text(as_csv(measurement))
    ended = enter(*IDENTIFY, "measurement.path=run.csv", "timeout=0.001", output="results/identify_run")
    assert ended.code == 1 and "nothing was identified" in ended.out and "1 of 1 failed" in ended.out


def test_angles_are_told_within_a_turn():
    origin = Parameter("phase_origin", "deg", np.pi / 180, -1.5 * np.pi, 1.5 * np.pi)
    half = Parameter("phase", "deg", np.pi / 180, -np.pi / 2, np.pi / 2)

    def degrees(value):
        return np.degrees(origin.turned(np.radians(value)))

    assert [degrees(value) for value in (-270, -180, 0, 180, 181, 270)] == pytest.approx([90, 180, 0, 180, -179, -90])
    assert half.turned(-np.pi / 2) == -np.pi / 2  # its bounds hold half a turn: no value is another's
    assert np.degrees(beside_truth(origin, np.radians(179), np.radians(-179))) == pytest.approx(-181)
    assert beside_truth(origin, None, 1.0) is None and beside_truth(half, 3.0, -3.0) == 3.0


def record_of(*parameters, **others):
    counts = {"updates": 0, "model_evaluations": 1, "model_jacobians": 0, "surrogate_evaluations": 0}
    return IdentificationRecord("done", "optimizer", parameters, 1.0, **counts, seconds=Seconds(), **others)


def beside_truth(parameter, true, identified):
    """The true value that a record has beside what was identified."""
    record = record_of(ParameterRecord(parameter.name, parameter.unit, parameter.si_per_unit, identified, False))
    truth = {} if true is None else {parameter.name: true}
    return record.with_truth(Parameters((parameter,)), truth).parameters[0].true


def test_the_verdict_is_read_from_the_record():
    line = fit_verdict(LackOfFit(0.0004, "Ljung–Box", rejected=True))
    assert line.startswith("the model does not fit") and "diagnose" in line and "p = 0.0004" in line
    accepted = LackOfFit(0.0004, "Ljung–Box", rejected=False)
    assert fit_verdict(accepted).startswith("fit: the residuals are consistent with noise")
    assert text(record_of(lack_of_fit=accepted)).splitlines()[-1] == fit_verdict(accepted)
    assert "the model" not in text(record_of())


def test_a_report_is_made_of_records_alone(example):
    Path(example.output.parent.parent / "run_up.csv").unlink(missing_ok=True)
    made = report_named("identification").make(read_plan(example.output), example.output)
    assert made.text.splitlines()[0] == example.out.splitlines()[0]


@pytest.mark.skipif(not RK4_RUN_UP.is_file(), reason=f"{RK4_RUN_UP} is not here: public data that are not committed")
def test_the_public_run_up_of_an_rk4_rig_is_read_and_fitted(enter, tmp_path):
    """Its probe is plane 1, x, phase lead, 0-peak already. Swept through the critical, it beats: no steady model fits."""
    with RK4_RUN_UP.open() as file:
        rows = [[row["rpm"], "0.12", "x", row["amp_1x_um_0pk"], row["phase_1x_deg"]] for row in csv.DictReader(file)]
    header = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg"
    (tmp_path / "rk4.csv").write_text("\n".join([header, *map(",".join, rows)]))
    ended = enter(*IDENTIFY, "problem=rk4_two_disk", "measurement.path=rk4.csv", output="results/identify_rk4")
    assert ended.code == 0, ended.err
    table = table_of(ended)
    assert list(table.index) == ["kxx", "kyy", "cxx", "cyy", "u1", "phase1", "u2", "phase2"]
    assert 0.06 < table.loc["kxx", "value"] < 0.09  # the owners' critical of 1648 rpm asks for 0.074
    assert pd.isna(table.loc["kyy", "low"])  # a probe in x hardly sees y
