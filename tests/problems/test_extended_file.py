"""A problem with effects from a YAML file: what is written is read again, and every slip is named with its place."""

from pathlib import Path

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.plugins import registry
from problems.extended_file import ExtendedFile
from problems.rotor.response.problem import RotorProblem
from problems.three_disk import ThreeDisk

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "rotor.yaml"
SMALL = """\
problem: {name: three_disk, mesh: 13, sensors: [0.1, 0.5], n_speed: 9}
effects:
  - {name: runout, position: 0.1}
  - {name: mass}
reference: {kxx: 55, runout_x: 8, mass_change: -2.5}
phase_origin: true
"""


@pytest.fixture
def write(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(content, name="extended.yaml"):
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return name

    return write


def effect(name, **settings):
    return registry.create("effect", name, settings)


def refused(**settings):
    with pytest.raises(SettingError) as caught:
        ExtendedFile(**settings)
    text = str(caught.value)
    assert "\n" not in text
    return text


def test_problem_effects_and_reference_values(write):
    settings = ExtendedFile(file=write(SMALL))
    plain = ThreeDisk(mesh=13, sensors=[0.1, 0.5], n_speed=9).build()
    expected = effect("mass").added_to(effect("runout", position=0.1).added_to(plain.with_phase_origin()))
    problem = settings.build()
    assert problem.parameters == expected.parameters
    x = problem.parameters.to_si(np.random.default_rng(1).random((3, 9)))
    assert np.array_equal(problem.response(x), expected.response(x))
    assert settings.reference() == pytest.approx(
        ThreeDisk().reference()
        | {"kxx": 55e6, "phase_origin": 0.0, "runout_x": 8e-6, "runout_y": 0.0, "mass_change": -0.025}
    )


def test_without_effects_it_is_the_plain_problem(write):
    settings = ExtendedFile(file=write("problem: {name: three_disk}\neffects: []\n"))
    assert isinstance(settings.build(), RotorProblem)
    assert settings.reference() == ThreeDisk().reference()


def test_another_mesh(write):
    problem = ExtendedFile(file=write(SMALL), mesh=21).build()
    assert len(problem.sites) == 22
    with pytest.raises(SettingError, match="at least 4 elements"):
        ExtendedFile(file="extended.yaml", mesh=2)


def test_the_fingerprint_follows_all_files(write):
    rotor = write(EXAMPLE.read_text(), "rotor.yaml")
    file = write(f"problem: {{name: rotor, file: {rotor}}}\neffects: []\n")
    prints = {ExtendedFile(file=file).fingerprint()}
    write(EXAMPLE.read_text() + "# a remark\n", "rotor.yaml")
    prints.add(ExtendedFile(file=file).fingerprint())
    write(f"problem: {{name: rotor, file: {rotor}}}\neffects: [{{name: mass}}]\n")
    prints.add(ExtendedFile(file=file).fingerprint())
    assert len(prints) == 3


def test_what_is_written_is_read_again(write):
    settings = {"name": "three_disk", "mesh": 21, "sensors": [0.1, 0.2], "limits": {"kxx": [20, 90.5]}}
    law = effect("speed_dependent_stiffness").placed_on(ThreeDisk().build())
    effects = [
        ("runout", effect("runout", position=np.float64(0.1))),
        ("speed_dependent_stiffness", law),
        ("channel_gain", effect("channel_gain", position=0.2, direction="y")),
        ("flexible_pedestal", effect("flexible_pedestal")),
    ]
    values = {"kxx": 50.1, "runout_x": np.float64(1e-7), "stiffness_slope": -12.0, "u": 1e20}
    written = ExtendedFile(file=write(ExtendedFile.document("three_disk", settings, effects, values, True)))
    problem = written.build()
    assert problem.effects == tuple(each for _, each in effects)
    assert problem.parameters.names[5] == "phase_origin" and problem.parameters.upper[0] == 90.5e6
    reference = written.reference()
    units = {parameter.name: parameter.si_per_unit for parameter in problem.parameters}
    assert {name: reference[name] / units[name] for name in values} == pytest.approx(values)
    assert (
        ExtendedFile(file=write(ExtendedFile.document("three_disk", {}, [], {}))).reference() == ThreeDisk().reference()
    )


def test_an_effect_at_two_places_is_written_and_read_again(write):
    effects = [("runout", effect("runout", position=position)) for position in (0.1, 0.5)]
    values = {"runout_x": 2.0, "runout_y_at_0_5_m": -3.0}
    written = ExtendedFile(file=write(ExtendedFile.document("three_disk", {"sensors": [0.1, 0.5]}, effects, values)))
    assert written.build().effects == tuple(each for _, each in effects)
    assert written.reference()["runout_y_at_0_5_m"] == pytest.approx(-3e-6)
    assert written.reference()["runout_x"] == pytest.approx(2e-6)


def test_an_extended_problem_is_extended_further(write):
    write(SMALL)
    text = ExtendedFile.document(
        "extended", {"file": "extended.yaml", "mesh": None}, [("residual_bow", effect("residual_bow"))], {"kxx": 60}
    )
    further = ExtendedFile(file=write(text, "further.yaml"))
    assert further.build().parameters.names[5:] == (
        "phase_origin", "runout_x", "runout_y", "mass_change", "bow_x", "bow_y",
    )  # fmt: skip
    assert further.reference()["kxx"] == pytest.approx(60e6) and further.reference()["runout_x"] == pytest.approx(8e-6)


def test_a_file_that_the_problem_names_is_found_from_anywhere(write, tmp_path, monkeypatch):
    write(EXAMPLE.read_text(), "rotor.yaml")
    file = write(ExtendedFile.document("rotor", {"file": "rotor.yaml"}, [("mass", effect("mass"))], {}))
    (tmp_path / "below").mkdir()
    monkeypatch.chdir(tmp_path / "below")
    assert ExtendedFile(file=f"../{file}").build().parameters.names[-1] == "mass_change"


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("three_disk", "three_disc", "problem.name: unknown problem 'three_disc'; did you mean 'three_disk'?"),
        ("three_disk", "extended", "problem.name: expected a problem without effects, got an extended one"),
        ("mesh: 13", "mesch: 13", "problem: unknown setting of problem=three_disk: 'mesch'; did you mean 'mesh'?"),
        ("mesh: 13", "mesh: many", "problem.mesh: expected a whole number, got 'many'"),
        ("mesh: 13", "mesh: 13.5", "problem.mesh: expected a whole number, got 13.5"),
        ("mesh: 13", "mesh: 3", "problem: problem=three_disk: mesh: expected at least 4 elements"),
        ("[0.1, 0.5]", "0.1", "problem.sensors: expected a list, each entry a number, got 0.1"),
        ("[0.1, 0.5]", "[0.1, a]", "problem.sensors: expected a number, got 'a'"),
        ("name: runout", "name: runot", "effects[1].name: unknown effect 'runot'; did you mean 'runout'?"),
        ("name: runout, ", "", "effects[1].name: expected a text, got nothing"),
        ("position: 0.1", "position: here", "effects[1].position: expected a number or null, got 'here'"),
        ("position: 0.1", "position: 5", "effects[1]: runout at 5 m: expected a position on the shaft"),
        ("position: 0.1", "position: -1", "effects[1]: effect=runout: position: expected a number at least 0"),
        ("name: mass", "name: runout, position: 0.1", "effects[2]: effects: expected each unknown once, got runout_x again"),
        ("runout_x: 8", "runout_xx: 8", "reference: unknown parameter 'runout_xx'; did you mean 'runout_x'?"),
        ("kxx: 55", "kxx: much", "reference.kxx: expected a number, got 'much'"),
        ("phase_origin: true", "phase_origin: 7", "phase_origin: expected a text, got 7"),
        ("phase_origin: true", "phase_origin: yes", "phase_origin: unknown value 'yes'"),
        ("phase_origin", "phase", "unknown key 'phase'; did you mean 'phase_origin'?"),
        ("effects:", "effekts:", "unknown key 'effekts'; did you mean 'effects'?"),
        ("problem: {name", "problem: [name", "line 1: expected YAML"),
        ("  - {name: runout, position: 0.1}\n  - {name: mass}\n", "  mass\n", "effects: expected a list"),
        ("{name: mass}", "mass", "effects[2]: expected a mapping"),
    ],
)  # fmt: skip
def test_slips(write, old, new, message):
    assert old in SMALL
    text = refused(file=write(SMALL.replace(old, new)))
    assert text.startswith("extended.yaml") and message in text


@pytest.mark.parametrize(
    "content, message",
    [(b"", "got nothing"), (b"\xff\xfe\x00", "UTF-8"), (b"- a\n", "a list"), (b"3\n", "got 3")],
)
def test_rubbish(write, content, message):
    assert message in refused(file=write(content))


def test_no_file(write):
    assert "give problem.file=extended.yaml" in refused()
    assert "found none" in refused(file="nowhere.yaml")


def test_what_is_no_rotor_of_this_project_takes_no_effect(write, monkeypatch):
    monkeypatch.setattr(ThreeDisk, "build", lambda self: object())
    assert "effects[1]: effects: expected a rotor of this project, got object" in refused(file=write(SMALL))
