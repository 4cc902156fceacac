"""Studies that look ahead take the middles of limits where no true value is known, and say so; others ask for the values."""

import pytest

import ksmea
from bench.plan.assumed_values import ASSUMED, with_assumed_values

STUDY = {"study": {"name": "identifiability"}}
ROTOR = """
units: {length: m, modulus: GPa, density: kg/m3, stiffness: MN/m, damping: kN s/m, unbalance: g mm, angle: deg, speed: rad/s}
materials: {steel: {young_modulus: 200, density: 7800, poisson_ratio: 0.3}}
shaft: [{length: 1.0, outer_diameter: 0.1, material: steel, elements: 4}]
disks: [{position: 0.5, outer_diameter: 0.4, inner_diameter: 0.1, thickness: 0.05, material: steel}]
bearings: [{position: 0.0, cxx: 1, cyy: 1}, {position: 1.0, cxx: 1, cyy: 1}]
unbalance: [{position: 0.5, phase: 0}]
speeds: {from: 100, to: 1000, number: 20}
probes: [{position: 0.25, direction: x}, {position: 0.25, direction: y}]
unknowns:
  - {name: kxx, lower: 10, upper: 1000, sets: [bearing 1 kxx, bearing 2 kxx]}
  - {name: kyy, lower: 20, upper: 60, sets: [bearing 1 kyy, bearing 2 kyy]}
  - {name: u, lower: 50, upper: 500, reference: 200, sets: [unbalance 1 magnitude]}
"""
# sqrt(10 · 1000) over two decades, (20 + 60)/2 within one; u has a reference
MIDDLES = {"kxx": 100.0, "kyy": 40.0}


@pytest.fixture
def settings(tmp_path):
    (tmp_path / "rotor.yaml").write_text(ROTOR)
    problem = {"name": "rotor", "file": str(tmp_path / "rotor.yaml")}
    return {**STUDY, "problem": problem, "measurement": {"name": "synthetic", "truth": {}}}


def test_what_has_no_value_is_in_the_middle_of_its_limits(settings):
    found = with_assumed_values(settings)
    assert found["measurement"]["truth"] == pytest.approx(MIDDLES) and found[ASSUMED] == ["kxx", "kyy"]
    given = {**settings, "measurement": {"name": "synthetic", "truth": {"kyy": 30.0}}}
    found = with_assumed_values(given)
    assert found["measurement"]["truth"] == pytest.approx({"kxx": 100.0, "kyy": 30.0}) and found[ASSUMED] == ["kxx"]


@pytest.mark.parametrize(
    "change",
    [
        {"study": {"name": "identify"}},  # its data are made of the truth
        {"measurement": {"name": "file", "path": "run.csv"}},
        {"problem": {"name": "three_disk"}},  # all values are published
    ],
)
def test_nothing_is_assumed_where_values_are_known_or_data_are_made_of_them(change, settings):
    assert with_assumed_values(settings | change) == settings | change


@pytest.mark.parametrize("values", [{}, {"kyy": 30.0}])
def test_from_python_the_same_values_are_taken_and_told(settings, values):
    rotor = ksmea.load_problem(settings["problem"]["file"])
    given = {**settings, "measurement": {"name": "synthetic", "truth": values}}
    truth = with_assumed_values(given)["measurement"]["truth"]
    look = {"relative": 0.05, "variations": []}
    found, told = (ksmea.identifiability(rotor, values=each, **look).record for each in (values, truth))
    assert [each.crlb for each in found.parameters] == [each.crlb for each in told.parameters] and not told.remarks
    [remark] = found.remarks
    assert remark.startswith(
        f"no value is known of {'kxx' if values else 'kxx, kyy'}: the middles of the limits are taken"
    )
    plan = ksmea.plan(rotor, "kxx", relative=0.05, values=values, add=1, sensors=0, trial_phases=[])
    assert plan.record.remarks[0] == remark and remark in str(plan)


def test_the_command_says_what_it_has_assumed_and_how_to_give_other_values(enter, settings):
    words = [
        "problem=rotor",
        "problem.file=rotor.yaml",
        "measurement.relative=0.05",
        "study.variations=[]",
        "workers=1",
    ]
    ended = enter("+experiment=identifiability", *words, output="results/identifiability")
    assert ended.code == 0, ended.err
    [note] = [line for line in ended.out.splitlines() if line.startswith("note: no value is known of kxx, kyy: ")]
    assert note.endswith("'measurement.truth={kxx:100.0,kyy:40.0}'")
    assert "no value is known of kxx, kyy" in (ended.output / "index.html").read_text()
    table = ended.table("identifiability").set_index("parameter")
    assert table["true"].to_dict() == pytest.approx({**MIDDLES, "u": 200.0})
    given = enter(
        "+experiment=identifiability", *words, note.rpartition(": ")[2].strip("'"), output="results/identifiability"
    )
    assert given.code == 0 and "no value is known" not in given.out


def test_assumed_values_without_a_steady_response_are_told_as_such(enter, settings, tmp_path):
    """Cross-coupling of both signs in the middle of its limits whirls the rotor up: nobody gave those values."""
    unknowns = """
  - {name: kxy, lower: 0, upper: 500, sets: [bearing 1 kxy, bearing 2 kxy]}
  - {name: kyx, lower: -500, upper: 0, sets: [bearing 1 kyx, bearing 2 kyx]}
"""
    (tmp_path / "rotor.yaml").write_text(ROTOR.rstrip("\n") + unknowns)
    words = ["problem=rotor", "problem.file=rotor.yaml", "measurement.relative=0.05", "workers=1"]
    ended = enter("+experiment=identifiability", *words, output="results/identifiability")
    assert (ended.code, ended.out) == (2, "") and len(ended.err.splitlines()) == 1
    assert ended.err.startswith("error: measurement.truth: expected a rotor that is stable up to")
    assert "no value is known of kxx, kyy, kxy, kyx: the middles of the limits are taken" in ended.err
    assert ended.err.endswith("'measurement.truth={kxx:100.0,kyy:40.0,kxy:250.0,kyx:-250.0}'\n")


@pytest.mark.parametrize(
    "study, words",
    [
        ("identifiability", ["study.variations=[]"]),
        ("plan", ["study.add=2", "study.sensors=0", "study.trial_phases=[]", "study.n_candidate=20"]),
    ],
)
def test_a_sweep_says_once_what_it_has_assumed(study, words, enter, settings):
    swept = ["problem=rotor", "problem.file=rotor.yaml", "measurement.relative=0.02,0.05,0.1", "workers=1"]
    ended = enter(f"+experiment={study}", *swept, *words, output=f"results/{study}")
    assert ended.code == 0, ended.err
    page = (ended.output / "index.html").read_text()
    assert ended.out.count("no value is known of kxx, kyy") == 1 == page.count("no value is known of kxx, kyy")
