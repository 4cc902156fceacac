"""The native measurement file: what it means, and one clear line for each file that does not fit."""

import dataclasses
import resource
import subprocess
import sys
import time

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.inference.cramer_rao import identifiability
from ksmea.inference.intervals import estimate
from ksmea.inference.maximisation import nearest_maximum
from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import FORMS, Misfit
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.problem.alignment import aligned
from ksmea.problem.counted import Model
from ksmea.problem.problem import Problem
from ksmea.units import RPM
from measurements.file import File
from measurements.run_up_csv import as_csv
from measurements.run_up_rows import MAX_ROWS
from problems.rk4_two_disk import RK4TwoDisk
from problems.three_disk import ThreeDisk

HEADER = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg,sigma_um"
ROW = "1000,0.1,x,2.5,30,"
GOOD = [ROW, "1000,0.1,y,1.5,-60,", "1200,0.1,x,3.5,31,", "1200,0.1,y,2.5,-61,"]


def text(*rows, header=HEADER):
    return "\n".join([header, *rows]) + "\n"


@pytest.fixture
def written(tmp_path, monkeypatch):
    """A file run.csv with this content in the working directory, as settings."""
    monkeypatch.chdir(tmp_path)

    def call(content, **settings):
        (tmp_path / "run.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
        return File(path="run.csv", **settings)

    return call


def measured(file):
    return file.measure(None, {}, None, None)


def test_values_units_and_phases_are_those_of_the_definition(written):
    data = measured(written(text(*GOOD)))
    assert data.speed == pytest.approx([1000 * np.pi / 30, 1200 * np.pi / 30])
    assert data.channels == (Channel(0.1, "x"), Channel(0.1, "y"))
    assert data.values[0, 0] == pytest.approx(2.5e-6 * np.exp(1j * np.pi / 6))
    # lead: the peak of Re(q e^{iΩt}) comes 30° before that of the reference
    angle = np.linspace(0, 2 * np.pi, 3601)
    peak = np.degrees(angle[np.argmax((data.values[0, 0] * np.exp(1j * angle)).real)])
    assert peak == pytest.approx(330, abs=0.1)
    assert data.noise is None and data.source == "run.csv"


@pytest.mark.parametrize("kind", ["amplitude", "complex"])
@pytest.mark.parametrize("with_noise", [False, True])
def test_what_is_written_is_read_again(written, kind, with_noise):
    rng = np.random.default_rng(3)
    values = rng.uniform(1e-6, 2e-5, (7, 3))
    if kind == "complex":
        values = values * np.exp(1j * rng.uniform(-np.pi, np.pi, values.shape))
    channels = (Channel(0.1, "x"), Channel(0.4, "y"), Channel(0.4, "x"))
    noise = Noise(0.0, rng.uniform(1e-7, 1e-6, values.shape)) if with_noise else None
    speed = np.sort(rng.uniform(100, 1500, 7))
    before = Measurement(speed, channels, values, noise, "made")
    instants = np.array([7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0])  # a coast-down
    file = written(as_csv(before, ["a remark"], instants))
    after = measured(file)
    assert after.channels == channels and file.kind == kind
    assert after.speed == pytest.approx(speed, rel=1e-8)
    assert after.values == pytest.approx(values, rel=1e-6)
    assert file.time == pytest.approx(instants)
    assert (after.noise is None) == (not with_noise) == (not file.noise_known)
    if with_noise:
        assert after.noise.relative == 0 and after.noise.floor == pytest.approx(noise.floor, rel=1e-7)


def test_remarks_empty_lines_bom_crlf_and_missing_optional_columns_are_fine(written):
    content = "# made by hand\n\nposition_m,direction,speed_rpm,amplitude_um_0pk\n0.1,x,1200,3\n,,,\n# more\n 0.1, x, 1000, 2\n"
    data = measured(written(b"\xef\xbb\xbf" + content.replace("\n", "\r\n").encode()))
    assert data.is_amplitude and data.values.ravel() == pytest.approx([2e-6, 3e-6])
    assert data.speed == pytest.approx(np.array([1000, 1200]) * RPM)
    assert measured(written(content.replace("\n", "\r"))).values == pytest.approx(data.values)


def test_speeds_that_lack_a_channel_are_left_out_only_where_that_is_said(written):
    rows = text(*GOOD, "1300,0.1,x,4,30,")
    file = written(rows, incomplete="drop")
    assert len(measured(file).speed) == 2 and file.remarks == ("1 of 3 speeds left out: a channel is missing there",)
    with pytest.raises(SettingError, match=r"measurement\.incomplete=drop"):
        written(rows)


def test_a_part_of_the_run_up_can_be_taken(written):
    rows = text(*(f"{speed},0.1,x,1,," for speed in range(1000, 2000, 100)))
    file = written(rows, speed_from=1200, speed_to=1500)
    assert measured(file).speed == pytest.approx(np.arange(1200, 1600, 100) * RPM)
    left_out, alone = file.remarks
    assert left_out == "6 of 10 rows left out by speed_from and speed_to"
    assert alone.startswith("amplitudes alone: phases would add")


def test_the_problem_is_seen_as_the_file_has_it_with_the_phase_origin_unknown(written):
    problem = ThreeDisk().build()
    file = written(text(*GOOD))
    adapted = aligned(problem, file.layout(None))
    assert adapted.speed == pytest.approx(measured(file).speed) and adapted.channels == measured(file).channels
    assert adapted.parameters.names == (*problem.parameters.names, "phase_origin")
    amplitudes = written(text("1000,0.1,x,2.5,,", "1200,0.1,x,3.5,,"))
    assert aligned(problem, amplitudes.layout(None)).parameters.names == problem.parameters.names
    # where all phases are unknown already, nothing is added
    rig = RK4TwoDisk().build()
    assert aligned(rig, written(text(*GOOD)).layout(None)).parameters.names == rig.parameters.names


class OfFixedPhase(Problem):
    """A problem that cannot leave the phase origin open."""

    parameters, speed, channels = ThreeDisk().build().parameters, np.array([1.0]), ()

    def response(self, x):
        raise NotImplementedError

    def at(self, speed, channels):
        return self


def test_phases_need_a_problem_that_can_leave_their_origin_open(written):
    with pytest.raises(SettingError, match=r"run\.csv: phases were measured.*OfFixedPhase; use the amplitudes alone"):
        aligned(OfFixedPhase(), written(text(*GOOD)).layout(None))
    amplitudes = written(text("1000,0.1,x,2.5,,", "1200,0.1,x,3.5,,"))
    assert isinstance(aligned(OfFixedPhase(), amplitudes.layout(None)), OfFixedPhase)


def test_the_fingerprint_is_that_of_the_content(written):
    first = written(text(*GOOD)).fingerprint()
    assert written(text(*GOOD)).fingerprint() == first
    assert written(text(*GOOD).replace("2.5", "2.6")).fingerprint() != first


UNKNOWN = "expected a number for amplitude_um_0pk, got "
BAD = {  # content, what the one line has to contain
    "empty": ("", "run.csv: expected the header speed_rpm,"),
    "blank": ("\n  \n", "run.csv: expected the header"),
    "remarks": ("# nothing\n", "got remarks only"),
    "no header": (text(*GOOD[1:], header=ROW), "line 1: expected a header, got numbers"),
    "no rows": (text(), "line 1: expected rows below the header, got none"),
    "wrong column": (text(ROW, header=HEADER.replace("speed_rpm", "speed")), "line 1: unknown column 'speed'; did you mean"),
    "column missing": (text("1000,0.1,x", header="speed_rpm,position_m,direction"), "got no amplitude_um_0pk"),
    "column twice": (text(ROW, header=HEADER.replace("sigma_um", "speed_rpm")), "got speed_rpm twice"),
    "upper case": (text(ROW, header=HEADER.upper()), "unknown column 'SPEED_RPM'"),
    "NaN": (text(*GOOD, "1300,0.1,x,NaN,30,"), f"line 6: {UNKNOWN}'NaN'; leave out rows that were not measured"),
    "inf": (text(*GOOD, "1300,0.1,x,inf,30,"), f"line 6: {UNKNOWN}'inf'"),
    "overflow": (text(*GOOD, "1300,0.1,x,1e999,30,"), "line 6: expected amplitude_um_0pk of at most 1e+06, got '1e999'"),
    "text": (text(*GOOD, "1300,0.1,x,high,30,"), f"line 6: {UNKNOWN}'high'"),
    "underscore": (text(*GOOD, "1300,0.1,x,1_0,30,"), f"line 6: {UNKNOWN}'1_0'"),
    "empty cell": (text(*GOOD, "1300,0.1,x,,30,"), f"line 6: {UNKNOWN}nothing"),
    "negative amplitude": (text(*GOOD, "1300,0.1,x,-1,30,"), "line 6: expected amplitude_um_0pk of 0 or more, got '-1'"),
    "at rest": (text(*GOOD, "0,0.1,x,1,30,"), "line 6: expected speed_rpm above 0, got '0'"),
    "no sigma": (text(*GOOD[:3], "1200,0.1,y,1,30,0"), "line 5: expected sigma_um above 0, got '0'"),
    "direction": (text(*GOOD, "1300,0.1,horizontal,1,30,"), "line 6: expected direction x, y or degrees from x towards y, got 'horizontal'"),
    "one speed": (text(*GOOD[:2]), "expected at least 2 speeds with every channel, got 1 (1000 rpm)"),
    "twice": (text(*GOOD, ROW), "line 6: expected each speed and channel once, got 1000 rpm, x at 0.1 m again after line 2"),
    "channel missing": (text(*GOOD[:3]), "line 4: expected every channel at every speed, got no y at 0.1 m at 1200 rpm"),
    "some phases": (text(*GOOD[:3], "1200,0.1,y,1,,"), "line 5: expected phase_lead_deg on every row or on none"),
    "some sigmas": (text(*GOOD[:3], "1200,0.1,y,1,3,0.1"), "line 2: expected sigma_um on every row or on none"),
    "semicolons": (text(*GOOD).replace(",", ";"), "line 1: expected columns separated by commas, got semicolons"),
    "tabs": (text(*GOOD).replace(",", "\t"), "line 1: expected columns separated by commas, got tabs"),
    "decimal commas": (text("1000,0,1,x,2,5,30,"), "line 2: expected 6 cells as in the header, got 8"),
    "quoted comma": (text('1000,"0,1",x,2,30,'), "line 2: expected a number for position_m, got '0,1'; write decimals"),
    "short row": (text("1000,0.1,x,2"), "line 2: expected 6 cells as in the header, got 4"),
    "open quote": (text('1000,0.1,"x,2,30,'), "line 2: expected cells separated by commas, got 'unexpected end of data'"),
    "time runs back": (
        text("1000,0.1,x,1,2", "1100,0.1,x,1,1", header="speed_rpm,position_m,direction,amplitude_um_0pk,time_s"),
        "line 3: expected rows in the order of time, got 1 s after 2 s",
    ),
    "UTF-16": (text(*GOOD).encode("utf-16"), "expected a text in UTF-8, got UTF-16; save it as 'CSV UTF-8'"),
    "UTF-16 bare": (text(*GOOD).encode("utf-16-le"), "line 1: expected a CSV text in UTF-8, got binary data or UTF-16"),
    "rubbish": (bytes(np.random.default_rng(1).integers(0, 256, 5000, dtype=np.uint8)), "expected a CSV text in UTF-8"),
    "PNG": (b"\x89PNG\r\n\x1a\n\0\0", "got binary data"),
    "Latin-1": (text(*GOOD).encode() + "# 3 µm\n".encode("latin-1"), "line 6: expected a CSV text in UTF-8, got the byte 0xb5"),
    "off the shaft": (text(*(row.replace("0.1", "100") for row in GOOD)), "line 2: sensor at 100 m: expected a position on"),
    "dead probe": (text("1000,0.1,x,0,,", "1100,0.1,x,0,,"), "line 2: expected amplitudes above 0, got 0 at more than half"),
    "too many": (
        text(*(f"{1 + place / 100},0.1,x,1,," for place in range(MAX_ROWS + 1))),
        f"line {MAX_ROWS + 2}: expected at most {MAX_ROWS} rows",
    ),
}  # fmt: skip


OFF = "off the shaft"  # which the file does not know


@pytest.mark.parametrize("case", [case for case in BAD if case != OFF])
def test_a_file_that_does_not_fit_is_one_clear_line(case, written):
    content, expected = BAD[case]
    with pytest.raises(SettingError) as caught:
        written(content)
    line = str(caught.value)
    assert "run.csv" in line and expected in line
    assert len(line) < 400 and line.isprintable()


@pytest.mark.parametrize("case", [OFF, "NaN", "PNG", "too many"])
def test_the_command_line_refuses_it_in_that_line(case, enter, tmp_path):
    content, expected = BAD[case]
    (tmp_path / "run.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
    ended = enter("+experiment=identify", "measurement.path=run.csv", output="results/identify_run")
    assert ended.code == 2 and ended.out == ""
    (line,) = ended.err.splitlines()
    assert line.startswith("error: ") and "run.csv" in line and expected in line
    assert len(line) < 400 and line.isprintable()
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    "words, expected",
    [
        (["measurement.path=."], "measurement=file: .: expected a CSV file, got a directory"),
        (["measurement.path=none.csv"], "none.csv: expected a CSV file, found none (working directory: "),
        (["measurement.path=/dev/zero"], "got something that is not a regular file"),
        ([], "path: expected the CSV file of a measurement, got none; give measurement.path=run.csv"),
        (["measurement.pth=run.csv"], "unknown setting 'measurement.pth'; did you mean 'measurement.path'?"),
        (["measurement.path=run.csv", "measurement.incomplete=dorp"], "unknown value for incomplete: 'dorp'; did you mean 'drop'?"),
        (["measurement.path=run.csv", "measurement.speed_from=5000"], "expected speeds from 5000 to inf rpm, got 1000 to 1200"),
        (["measurement.path=run.csv", "measurement.speed_from=9", "measurement.speed_to=8"], "swap them"),
        (["measurement.path=run.csv", "measurement.speed_from=-1"], "speed_from: expected a number above 0, got -1"),
        (["measurement.path=run.csv", "study.basin=true"], "study.basin: expected true values to compare with"),
    ],
)  # fmt: skip
def test_a_setting_that_does_not_fit_is_one_clear_line(words, expected, enter, tmp_path):
    (tmp_path / "run.csv").write_text(text(*GOOD))
    ended = enter("+experiment=identify", *words)
    assert ended.code == 2, ended.out
    (line,) = ended.err.splitlines()
    assert expected in line


MILLION = """
import resource, time
from measurements.file import File
from ksmea.errors import SettingError
started = time.perf_counter()
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    File(path="run.csv")
except SettingError as error:
    print(error)
print(time.perf_counter() - started, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
"""


def test_a_million_rows_are_refused_quickly_and_in_bounded_memory(tmp_path):
    (tmp_path / "run.csv").write_text(text(*(f"{1 + place / 1000:.3f},0.1,x,1.0,30," for place in range(1_000_000))))
    done = subprocess.run([sys.executable, "-c", MILLION], cwd=tmp_path, capture_output=True, text=True, check=True)
    line, numbers = done.stdout.splitlines()
    seconds, megabytes = map(float, numbers.split())
    assert "line 100002: expected at most 100000 rows" in line
    assert seconds < 20 and megabytes < 400


def test_as_many_rows_as_allowed_are_read_quickly(written):
    started = time.perf_counter()
    file = written(text(*(f"{1 + place / 100:.2f},0.1,x,1.0,30,0.1" for place in range(MAX_ROWS))))
    assert len(measured(file).speed) == MAX_ROWS
    assert time.perf_counter() - started < 20


def test_a_huge_file_is_not_even_read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with open("run.csv", "wb") as file:
        file.truncate(10 * 2**30)  # sparse: it takes no place on the disk
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(SettingError, match=r"expected at most 100000 rows, got 10240 MB"):
        File(path="run.csv")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50 * 1024


def test_known_noise_that_is_the_same_everywhere_is_that_of_one_floor():
    """In whatever sees noise: misfit, likelihood, intervals, CRLBs."""
    problem = ThreeDisk().build()
    x = np.array([ThreeDisk().reference()[name] for name in problem.parameters.names])
    u = problem.parameters.to_cube(x)
    response = problem.response(x[None])[0]
    rng = np.random.default_rng(4)
    for kind in ("amplitude", "complex"):
        clean = np.abs(response) if kind == "amplitude" else response
        values = clean + 1e-7 * rng.standard_normal(clean.shape)
        one = Measurement(problem.speed, problem.channels, values, Noise(0.0, 1e-7), "one")
        each = dataclasses.replace(one, noise=Noise(0.0, np.full(clean.shape, 1e-7)))
        assert one.has_noise and each.has_noise
        shifted = problem.response(x[None] * 1.001)
        for form in FORMS:
            a, b = (Misfit(data, form) for data in (one, each))
            assert np.array_equal(a.residuals(a.observed(shifted)), b.residuals(b.observed(shifted)))
            slope = problem.sensitivity(x)
            assert np.array_equal(a.jacobian(response, slope), b.jacobian(response, slope))
        found = [
            estimate(likelihood, nearest_maximum(likelihood, u))
            for likelihood in (Likelihood(Model(problem), data) for data in (one, each))
        ]
        assert np.array_equal(found[0].x, found[1].x) and found[0].intervals == found[1].intervals
        bounds = [identifiability(problem, x, data.noise, kind).crlb for data in (one, each)]
        assert np.array_equal(*bounds)
        unknown = [identifiability(problem, x, data.noise, kind, noise_known=False).crlb for data in (one, each)]
        assert np.array_equal(*unknown)
    assert Noise(0.0, np.zeros((2, 2))).is_absent and not Noise(0.0, np.eye(2)).is_absent
