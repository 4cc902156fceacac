"""The Python API: what stands in its stub is there, it aligns or refuses, and its results speak like the command line."""

import dataclasses
import json
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.figure import Figure

import ksmea
from ksmea.errors import SettingError
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.identification import IdentificationRecord
from ksmea.records.location import LocationRecord
from ksmea.units import RPM
from measurements.run_up_csv import as_csv
from optimizers.de import DE
from optimizers.lm import LM

FAST = {"optimizer": LM(screening=1000, starts=3)}
NOISE = {"relative": 0.05, "floor": 0.1}


@pytest.fixture(scope="module")
def rotor():
    return ksmea.load_problem("three_disk", sensors=[0.1, 0.5])


@pytest.fixture(scope="module")
def data(rotor):
    return ksmea.synthetic_measurement(rotor, kind="complex", noise_known=False, phase_known=False, rng=1, **NOISE)


@pytest.fixture(scope="module")
def found(rotor, data):
    return ksmea.identify(rotor, data, **FAST)


# -- the names --


@pytest.mark.parametrize("name", ksmea.__all__)
def test_every_name_of_the_stub_is_there(name):
    assert getattr(ksmea, name).__doc__


def test_importing_loads_nothing_else():
    code = (
        "import sys, ksmea, bench; print([name for name in ('numpy', 'pandas', 'matplotlib') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


# -- results as values --


def test_an_identification_is_a_mapping_of_its_values(found, rotor):
    """Its response is that at its values; the origin of measured phases belongs to the data."""
    assert len(found) == len(dict(found)) == len(found.record.parameters) and next(iter(found)) == "kxx"
    numbers = {name: value.value for name, value in found.items() if name in rotor.parameters.names}
    assert float(found["kxx"]) == found["kxx"].value
    assert "phase_origin" in found and np.array_equal(rotor.response(found), rotor.response(numbers))


# -- problems --


def test_values_go_by_name_and_unit(rotor):
    assert rotor.reference == pytest.approx({"kxx": 50, "kyy": 70, "cxx": 0.5, "cyy": 0.7, "u": 200})
    assert rotor.x({"kxx": 40.0}) == pytest.approx([40e6, 70e6, 500, 700, 2e-4])
    assert rotor.response({"u": 400.0}) == pytest.approx(2 * rotor.response(), rel=1e-12)
    there = rotor.response(speed=[100.0, 200.0], channels=[ksmea.Channel(1.0, "x")])
    assert there.shape == (2, 1)
    with pytest.raises(SettingError, match="did you mean 'kxx'"):
        rotor.x({"kx": 40.0})


def test_a_value_that_nobody_knows_must_be_given():
    rk4 = ksmea.load_problem("rk4_two_disk")
    unknown = set(rk4.parameters.names) - set(rk4.reference)
    if unknown:
        with pytest.raises(SettingError, match="expected a value for"):
            rk4.x()


def test_modes_are_those_of_the_rotor(rotor):
    """Table of Lalanne & Ferraris for this rotor: 55.41 Hz is the first of 25 000 rpm; critical speeds as published."""
    modes = rotor.modes(25_000 * RPM, n_mode=2)
    assert [mode.frequency / (2 * np.pi) for mode in modes] == pytest.approx([55.41, 67.20], abs=0.02)
    assert rotor.critical_speeds() / RPM == pytest.approx([3620.4, 3798.1, 10017.0, 11278.4], abs=0.5)
    campbell = rotor.campbell(np.array([0.0, 25_000 * RPM]), n_mode=2)
    assert campbell.frequency[1] == pytest.approx([mode.frequency for mode in modes], rel=1e-9)


@pytest.mark.parametrize(
    "name, settings, message",
    [
        ("three_disks", {}, "did you mean 'three_disk'"),
        ("three_disk", {"meshes": 21}, "did you mean 'mesh'"),
        ("three_disk", {"mesh": "fine"}, "mesh: expected a whole number, got 'fine'"),
        ("missing.yaml", {}, "missing.yaml: expected a YAML file, found none"),
    ],
)
def test_what_cannot_be_loaded_is_refused_in_one_line(name, settings, message):
    with pytest.raises(SettingError, match=message) as caught:
        ksmea.load_problem(name, **settings)
    assert "\n" not in str(caught.value)


def test_it_shows_itself(rotor):
    assert str(rotor).splitlines()[1].split()[:2] == ["unknown", "unit"]
    assert "<td>kxx</td>" in rotor._repr_html_()


# -- problem and measurement --


def test_a_problem_at_other_speeds_is_aligned(rotor, data, found):
    """As many speeds, but others: an identification of these would come out far off and confident."""
    other = ksmea.load_problem("three_disk", sensors=[0.1, 0.5], speed_from=300.0, speed_to=1600.0)
    again = ksmea.identify(other, data, **FAST)
    assert [item.identified for item in again.record.parameters] == pytest.approx(
        [item.identified for item in found.record.parameters], rel=1e-6
    )


def test_what_cannot_be_aligned_is_refused(rotor, data):
    shifted = dataclasses.replace(data.measurement, channels=tuple(ksmea.Channel(9.0, "x") for _ in range(4)))
    for study in (ksmea.identify, ksmea.diagnose):
        with pytest.raises(SettingError, match="9 m: expected a position on the shaft"):
            study(rotor, shifted)


def test_a_path_in_place_of_a_measurement_is_refused_with_what_reads_it(rotor):
    with pytest.raises(SettingError, match=r"got str; ksmea\.read_measurement\(path\) reads a file"):
        ksmea.identify(rotor, "docs/examples/run_up.csv")


def test_the_truth_stays_beside_the_measurement(rotor):
    hidden = ksmea.synthetic_measurement(rotor, hidden=["runout"], kind="complex", rng=5, **NOISE)
    again = ksmea.synthetic_measurement(rotor, hidden=["runout"], kind="complex", rng=5, **NOISE)
    assert hidden.truth["kxx"] == 50.0
    [effect] = hidden.hidden
    assert effect.effect == "runout" and str(effect).startswith("runout (at 0.")
    assert np.array_equal(hidden.measurement.values, again.measurement.values) and hidden.hidden == again.hidden
    x = rotor.x()
    plain = rotor.response()
    vector = {item.name: item.value for item in effect.parameters}
    change = np.abs(hidden.measurement.values - plain).mean() * 1e6
    assert change > 0.1 * np.hypot(*vector.values()) and len(x) == 5


# -- data as tables --


def test_a_table_of_data_is_the_file_of_them(data, tmp_path):
    path = tmp_path / "run.csv"
    data.measurement.to_frame().to_csv(path, index=False)
    again = ksmea.read_measurement(path)
    np.testing.assert_allclose(again.values, data.measurement.values, rtol=1e-12)
    np.testing.assert_allclose(again.speed, data.measurement.speed, rtol=1e-12)
    assert again.channels == data.measurement.channels


def test_data_print_in_a_line(data):
    assert repr(data.measurement) == (
        "<Measurement synthetic: 53 speeds from 1910 to 14324 rpm, complex at x at 0.1 m, y at 0.1 m, x at 0.5 m, y at 0.5 m>"
    )
    assert "<table" in data.measurement._repr_html_() and "&lt;" not in data.measurement._repr_html_()
    assert "part(" not in repr(data.measurement.part(np.arange(0))) and "0 speeds" in repr(
        data.measurement.part(np.arange(0))
    )


# -- results --


def test_residuals_are_in_standard_deviations_of_the_noise(rotor):
    """Of known noise at the fit of a right model: chi-squared with n - d degrees of freedom, within four standard deviations."""
    made = ksmea.synthetic_measurement(rotor, kind="complex", rng=2, **NOISE)
    table = ksmea.identify(rotor, made, **FAST).residuals()
    parts = table[["residual_in_phase_sd", "residual_in_quadrature_sd"]].to_numpy()
    n = parts.size - 5
    assert np.sum(parts**2) == pytest.approx(n, abs=4 * np.sqrt(2 * n))
    change = table["measured_um_0pk"] * np.exp(1j * np.radians(table["measured_lead_deg"]))
    np.testing.assert_allclose(change, made.measurement.values.ravel() * 1e6, rtol=1e-6)


def test_a_prediction_scatters_as_values_of_the_covariance_do(rotor, found):
    """2000 draws: a standard deviation is known to 1.6 %, and responses are nearly linear within the intervals."""
    speed = np.array([300.0, 800.0])
    table = rotor.prediction(found, speed=speed)
    names = list(found)
    drawn = np.random.default_rng(3).multivariate_normal(found.record.values, found.record.covariance, 2000)
    problem = rotor.problem.at(speed, rotor.channels)  # of the rotor, whose phases have no origin to be found
    responses = problem.response(drawn[:, [names.index(name) for name in problem.parameters.names]]).reshape(2000, -1)
    np.testing.assert_allclose(table["amplitude_sd_um"], 1e6 * np.std(np.abs(responses), axis=0), rtol=0.1)
    turned = np.angle(responses / np.mean(responses, axis=0), deg=True)
    np.testing.assert_allclose(table["phase_sd_deg"], np.std(turned, axis=0), rtol=0.1)


def test_a_prediction_needs_closed_intervals(rotor, data):
    plain = ksmea.identify(rotor, data, intervals="none", **FAST)
    with pytest.raises(SettingError, match="expected an identification with a closed interval"):
        rotor.prediction(plain)


class Spring(ksmea.Problem):
    """One mass on a spring and a damper, seen at its own speeds alone."""

    def __init__(self):
        self.parameters = Parameters((Parameter("k", "N/m", 1.0, 1.0, 100.0), Parameter("c", "N s/m", 1.0, 0.01, 1.0)))
        self.speed, self.channels = np.linspace(1.0, 10.0, 30), (ksmea.Channel(0.0, "x"),)

    def response(self, x):
        k, c = x[:, 0, None], x[:, 1, None]
        return (1e-3 * self.speed**2 / (k - self.speed**2 + 1j * c * self.speed))[:, :, None]


def test_a_problem_that_is_no_rotor():
    spring = Spring()
    values = spring.response(np.array([[30.0, 0.3]]))[0]
    noise = 0.03 * np.random.default_rng(0).standard_normal((*values.shape, 2)) @ np.array([1, 1j])
    made = ksmea.Measurement(spring.speed, spring.channels, values * (1 + noise), None, "made")
    found = ksmea.identify(spring, made)
    assert found["k"].low < 30 < found["k"].high and len(found.residuals()) == 30
    with pytest.raises(SettingError, match="problem that effects can act on, got one on which none of"):
        ksmea.diagnose(spring, made)
    with pytest.raises(SettingError, match=r"expected one of ksmea\.load_problem or a ksmea\.Problem, got str"):
        ksmea.identify("three_disk", made)


def test_a_seed_is_given_as_rng(rotor, data):
    with pytest.raises(SettingError, match="write rng=3"):
        ksmea.identify(rotor, data, seed=3)


def test_an_identification_holds_the_truth_in_its_intervals(found):
    """95 % each; this draw has all six."""
    truth = {"kxx": 50.0, "kyy": 70.0, "cxx": 0.5, "cyy": 0.7, "u": 200.0}
    assert all(found[name].low < value < found[name].high for name, value in truth.items())
    assert str(found["kxx"]).startswith("kxx = ") and found["kxx"].unit == "MN/m"
    with pytest.raises(SettingError, match="did you mean 'kxx'"):
        found["kx"]


@pytest.mark.slow
def test_its_text_is_the_command_lines(found, data, shell_identify):
    """A file through the command line, whose optimiser draws other numbers, ends in an equal maximum."""
    printed = shell_identify(as_csv(data.measurement))
    ours = [line for line in str(found).splitlines() if line.startswith("  ")]
    assert ours and all(line in printed for line in ours)


@pytest.fixture
def shell_identify(tmp_path):
    def call(text):
        (tmp_path / "run.csv").write_text(text)
        words = ["+experiment=identify", "measurement.path=run.csv", "optimizer.screening=1000", "optimizer.starts=3"]
        command = [sys.executable, "-m", "bench", *words, "workers=1"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call


def test_a_result_is_table_figure_and_json(found, tmp_path):
    frame = found.to_frame()
    assert list(frame["parameter"]) == ["kxx", "kyy", "cxx", "cyy", "u", "phase_origin"]
    assert IdentificationRecord.from_data(json.loads(found.to_json(tmp_path / "found.json"))) == found.record
    assert json.loads((tmp_path / "found.json").read_text())["parameters"][0]["name"] == "kxx"
    whole = found.plot()
    assert len(whole.get_axes()) == 12 and whole._repr_png_().startswith(b"\x89PNG")
    axes = Figure().subplots()
    assert found.plot(axes) is axes.get_figure() and axes.lines
    assert "<table" in found._repr_html_()


def test_markup_in_names_stays_text(rotor, data):
    marked = dataclasses.replace(data.measurement, source="<b>run</b>.csv")
    shown = ksmea.identify(rotor, marked, intervals="none", **FAST)._repr_html_()
    assert "<b>run" not in shown and "&lt;b&gt;run" in shown


def test_methods_are_named_or_made_by_hand(rotor):
    data = ksmea.synthetic_measurement(rotor, relative=0.02)
    small = {"optimizer": DE(generations=5, population=10), "samples": 30}
    named = ksmea.identify(rotor, data, "ksmea", max_updates=2, rng=3, **small)
    again = ksmea.identify(rotor, data, "ksmea", max_updates=2, rng=np.random.default_rng(3), **small)
    assert named.record.updates <= 2 and named.record.model_evaluations == 30 + named.record.updates
    assert [item.identified for item in named.record.parameters] == [
        item.identified for item in again.record.parameters
    ]
    with pytest.raises(SettingError, match="did you mean 'max_updates'"):
        ksmea.identify(rotor, data, "ksmea", max_update=2, **small)


@pytest.mark.slow
def test_a_diagnosis_extends_the_problem(tmp_path):
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.5], n_speed=27)  # each speed takes a fit at each site
    hidden = ksmea.synthetic_measurement(
        rotor,
        hidden=["runout"],
        sizes={"runout_x": 6.0, "runout_y": 0.0},
        kind="complex",
        noise_known=False,
        rng=2,
        **NOISE,
    )
    result = ksmea.diagnose(rotor, hidden, effects=["runout", "mass"], starts=3, screening=512)
    assert (result.verdict, result.named) == ("named", ("runout",))
    (tmp_path / "extended.yaml").write_text(result.extended_yaml)
    extended = ksmea.load_problem(tmp_path / "extended.yaml")
    assert extended.reference["runout_x"] == pytest.approx(6.0, abs=0.5)
    assert (
        str(result).startswith("Runout of 6.0")
        and "\nThe model as given does not fit" in str(result)
        and "runout" in set(result.to_frame()["effect"])
    )
    assert set(result.coefficients()["unknown"]) == {*rotor.parameters.names, "runout_x", "runout_y"}
    assert DiagnosisRecord.from_data(json.loads(result.to_json())) == result.record
    assert result.plot().get_axes() and result.plot(Figure().subplots()).get_axes()
    assert "reading" in {site.kind for site in result.location.record.sites}  # a second opinion
    with pytest.raises(SettingError, match="did you mean 'runout'"):
        ksmea.diagnose(rotor, hidden, effects=["run_out"])


def test_a_location_says_where_something_acts(rotor):
    hidden = ksmea.synthetic_measurement(
        rotor, hidden=["unbalance"], sizes={"unbalance_x": 60.0}, kind="complex", noise_known=False, rng=2, **NOISE
    )
    result = ksmea.locate(rotor, hidden, positions=[0.2, 1.0], kinds=["force"])
    true = float(hidden.hidden[0].location.removeprefix("at ").removesuffix(" m"))
    assert result.record.kind == "force" and true in result.sites
    assert "An unknown force that is free at every speed explains the data at" in str(result)
    assert len(result.to_frame()) == 2
    assert LocationRecord.from_data(json.loads(result.to_json())) == result.record
    assert result.plot().get_axes() and result.plot(Figure().subplots()).get_axes()
    with pytest.raises(SettingError, match="measure phases"):
        ksmea.locate(rotor, ksmea.synthetic_measurement(rotor, **NOISE))


def test_what_could_be_known_and_what_to_add(rotor):
    told = ksmea.identifiability(rotor, relative=0.1, variations=["kind"])
    assert told.to_frame()["parameter"].iloc[0] == "kxx" and "you will know" in str(told)
    planned = ksmea.plan(rotor, "cyy", relative=0.1, add=2, sensors=1, trial_phases=[], n_candidate=20)
    assert {family.family for family in planned.record.families} == {"speeds", "probes"}
    for result in (told, planned):
        assert result.plot().get_axes() and result.plot(Figure().subplots()).get_axes() and result.to_json()
    with pytest.raises(SettingError, match="expected some"):
        ksmea.identifiability(rotor)
