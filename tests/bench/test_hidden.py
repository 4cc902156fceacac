"""Effects hidden in synthetic data: drawn by the seed, told to the record, and to nobody who identifies."""

import dataclasses
import json

import numpy as np
import pytest

from bench.plan.plan import SEED_PLACES, component_seeds, generator
from bench.plan.provenance import code_digest, used_modules
from bench.plan.setup import Draw, Setup
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.problem.alignment import aligned
from ksmea.records.hidden import HiddenEffect
from measurements.synthetic import Synthetic
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.2], n_speed=9)
PLAIN = PROBLEM.build()
TRUTH = PROBLEM.reference()
X = np.array([TRUTH[name] for name in PLAIN.parameters.names])


def stream(seed=0):
    return generator(component_seeds(seed, 0)["hidden"])


def refused(call):
    with pytest.raises(SettingError) as caught:
        call()
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_the_hidden_stream_has_a_place_of_its_own():
    assert SEED_PLACES["hidden"] == 5 and len(set(SEED_PLACES.values())) == len(SEED_PLACES)


def test_nothing_hidden_is_the_plain_response_and_takes_no_draw():
    synthetic = Synthetic(kind="complex")
    assert np.array_equal(synthetic.response(PROBLEM, TRUTH, stream()), PLAIN.response(X[None])[0])
    assert synthetic.parts == [] and synthetic.hidden_effects(PROBLEM, stream()) == ()


@pytest.mark.parametrize("name", [name for name in registry.registered("effect") if name != "local_force"])
def test_each_effect_is_in_the_data_as_the_record_says(name):
    synthetic = Synthetic(kind="complex", hidden=[name])
    [told] = synthetic.hidden_effects(PROBLEM, stream())
    assert told.effect == name and HiddenEffect.from_data(json.loads(json.dumps(told.to_data()))) == told
    [place] = [each for each in registry.create("effect", name, {}).locations(PLAIN) if str(each) == told.location]
    extended = place.added_to(PLAIN)
    own = extended.parameters.items[len(X) :]
    assert [(each.name, each.unit) for each in told.parameters] == [(item.name, item.unit) for item in own]
    theta = [each.value * item.si_per_unit for each, item in zip(told.parameters, own)]
    expected = extended.response(np.concatenate([X, theta])[None])[0]
    found = synthetic.response(PROBLEM, TRUTH, stream())
    assert found == pytest.approx(expected, rel=1e-9)
    assert not np.allclose(found, PLAIN.response(X[None])[0], rtol=1e-6)
    dense = dataclasses.replace(synthetic, route="dense").response(PROBLEM, TRUTH, stream())
    assert np.abs(dense - found).max() < 1e-8 * np.abs(found).max()


def test_place_and_size_are_drawn_by_the_seed_and_given_sizes_stay():
    synthetic = Synthetic(kind="complex", hidden=["runout", "mass"])
    told = [synthetic.hidden_effects(PROBLEM, stream(seed)) for seed in range(20)]
    assert told[3] == synthetic.hidden_effects(PROBLEM, stream(3))
    assert {each[0].location for each in told} == {"at 0.1 m", "at 0.2 m"}
    assert len({each[1].parameters[0].value for each in told}) == 20
    given = dataclasses.replace(synthetic, sizes={"runout_y": -4.0, "mass_change": 2.0})
    [runout, mass] = given.hidden_effects(PROBLEM, stream(3))
    assert runout.parameters[0] == told[3][0].parameters[0] and runout.location == told[3][0].location
    assert runout.parameters[1].value == pytest.approx(-4) and mass.parameters[0].value == pytest.approx(2)


def test_one_effect_can_hide_at_two_places():
    sizes = {
        "runout_x": 1.0,
        "runout_x_at_0_1_m": 2.0,
        "runout_x_at_0_2_m": 2.0,
    }  # as drawn, one of the latter is not there
    synthetic = Synthetic(kind="complex", hidden=["runout", "runout"])
    one, other = synthetic.hidden_effects(PROBLEM, stream(3))
    assert {one.location, other.location} == {"at 0.1 m", "at 0.2 m"}
    second = f"runout_x_{other.location}".replace(" ", "_").replace(".", "_")
    assert [part.name for part in (*one.parameters[:1], *other.parameters[:1])] == ["runout_x", second]
    given = dataclasses.replace(synthetic, sizes={name: sizes[name] for name in ("runout_x", second)})
    assert [each.parameters[0].value for each in given.hidden_effects(PROBLEM, stream(3))] == pytest.approx([1.0, 2.0])


def test_what_is_hidden_can_be_added_to_the_model_that_fits_for_judging_it():
    """The fitted problem with the hidden effects at their true values responds as the data do, but for its mesh."""
    settings = {"name": "three_disk", "mesh": 13, "sensors": [0.1, 0.2], "n_speed": 9}
    measurement = {"name": "synthetic", "kind": "complex", "mesh": 26, "hidden": ["runout", "mass"]}
    setup = Setup.of({"problem": settings, "measurement": measurement})
    draw = Draw(component_seeds(0, 3))
    problem, x = setup.with_hidden(draw)
    assert problem.parameters.names[-3:] == ("runout_x", "runout_y", "mass_change")
    response, expected = problem.response(x[None])[0], setup.measure(draw).values
    assert np.abs(response - expected).max() < 0.02 * np.abs(expected).max()  # 13 against 26 elements
    assert Setup.of({"problem": settings, "measurement": {**measurement, "hidden": []}}).with_hidden(draw) is None


def test_what_is_drawn_does_not_depend_on_what_was_asked_before():
    """The last draw is kept; the generator goes on as if it had been drawn again."""
    asked, fresh = (Synthetic(kind="complex", hidden=["runout", "mass"]) for _ in range(2))
    asked.response(PROBLEM, TRUTH, stream(3))
    one, other = stream(3), stream(3)
    told = [asked.hidden_effects(PROBLEM, one) for _ in range(2)]
    assert told == [fresh.hidden_effects(PROBLEM, other) for _ in range(2)] and told[0] != told[1]
    assert one.random() == other.random()
    elsewhere = {**TRUTH, "kxx": 0.5 * TRUTH["kxx"]}
    assert not np.allclose(
        asked.response(PROBLEM, elsewhere, stream(3)), asked.response(PROBLEM, TRUTH, stream(3)), rtol=1e-3
    )


def test_the_noise_is_the_same_with_and_without_hidden_effects():
    noisy = Synthetic(kind="complex", floor=1.0)
    hiding = dataclasses.replace(noisy, hidden=["runout"])
    noise = noisy.measure(PROBLEM, TRUTH, np.random.default_rng(1), stream()).values - noisy.response(
        PROBLEM, TRUTH, stream()
    )
    measured = hiding.measure(PROBLEM, TRUTH, np.random.default_rng(1), stream())
    assert measured.values - hiding.response(PROBLEM, TRUTH, stream()) == pytest.approx(noise, abs=1e-18)


def test_the_measurement_tells_nothing_of_what_it_hides():
    measured = Synthetic(kind="complex", floor=1.0, hidden=["runout"], sizes={"runout_x": 7.0}).measure(
        PROBLEM, TRUTH, np.random.default_rng(1), stream()
    )
    plain = Synthetic(kind="complex", floor=1.0).measure(PROBLEM, TRUTH, np.random.default_rng(1), stream())
    for field in dataclasses.fields(measured):
        if field.name not in ("values", "speed"):
            assert getattr(measured, field.name) == getattr(plain, field.name)


def test_a_finer_mesh_makes_nearly_the_same_data_below_resonance():
    synthetic = Synthetic(kind="complex", hidden=["residual_bow"], mesh=52)
    slow = dataclasses.replace(PROBLEM, reading="rpm")
    fine = synthetic.response(slow, TRUTH, stream())
    coarse = dataclasses.replace(synthetic, mesh=None).response(slow, TRUTH, stream())
    assert fine == pytest.approx(coarse, rel=1e-5) and not np.allclose(fine, coarse, rtol=1e-9, atol=0)


def test_effects_hide_behind_an_extended_problem(tmp_path):
    file = tmp_path / "extended.yaml"
    file.write_text(
        "problem: {name: three_disk, sensors: [0.1, 0.2]}\neffects: [{name: mass}]\nreference: {mass_change: 1}"
    )
    settings = registry.create("problem", "extended", {"file": str(file)})
    synthetic = Synthetic(kind="complex", hidden=["runout"])
    truth = synthetic.true_values(settings)
    assert truth["mass_change"] == pytest.approx(0.01)
    assert synthetic.response(settings, truth, stream()).shape == (53, 4)
    again = refused(lambda: Synthetic(hidden=["mass"]).true_values(settings))
    assert "measurement.hidden: mass: effects: expected each unknown once, got mass_change again" in again


# An unknown phase origin.


def test_an_unknown_phase_origin_is_one_more_unknown_of_complex_data():
    free = Synthetic(kind="complex", phase_known=False)
    problem = aligned(PLAIN, free.layout(PROBLEM))
    assert problem.parameters.names == (*PLAIN.parameters.names, "phase_origin")
    truth = free.true_values(PROBLEM)
    assert truth == TRUTH | {"phase_origin": 0.0}
    assert free.response(PROBLEM, truth, stream()) == pytest.approx(PLAIN.response(X[None])[0])
    assert aligned(problem, free.layout(PROBLEM)).parameters == problem.parameters
    for unchanged in (Synthetic(kind="amplitude", phase_known=False), Synthetic(kind="complex")):
        assert aligned(PLAIN, unchanged.layout(PROBLEM)) is PLAIN


def test_a_true_phase_origin_turns_the_data():
    turned = Synthetic(kind="complex", phase_known=False, truth={"phase_origin": 30.0})
    truth = turned.true_values(PROBLEM)
    assert turned.response(PROBLEM, truth, stream()) == pytest.approx(
        np.exp(1j * np.pi / 6) * PLAIN.response(X[None])[0]
    )


# What is refused.


@pytest.mark.parametrize(
    "settings, message",
    [
        ({"hidden": ["runot"]}, "unknown effect in hidden: 'runot'; did you mean 'runout'?"),
        ({"sizes": {"runout_x": 1.0}}, "sizes: expected hidden effects that have them, got none"),
        ({"route": "dence"}, "did you mean 'dense'?"),
    ],
)
def test_bad_settings(settings, message):
    assert message in refused(lambda: Synthetic(**settings))


@pytest.mark.parametrize(
    "problem, settings, message",
    [
        (PROBLEM, {"hidden": ["runout"], "sizes": {"runout_z": 1.0}}, "measurement.sizes: 'runout_z'; did you mean"),
        (
            PROBLEM,
            {"hidden": ["mass", "mass"]},
            "measurement.hidden: expected effects that have a location here, got mass",
        ),
        (
            dataclasses.replace(PROBLEM, directions=["x"]),
            {"hidden": ["probe_rotation"]},
            "expected effects that have a location here, got probe_rotation",
        ),
    ],
)
def test_what_does_not_fit_the_problem_is_refused_before_any_run(problem, settings, message):
    synthetic = Synthetic(**settings)
    assert message in refused(lambda: synthetic.true_values(problem))


def test_without_a_generator_nothing_is_hidden_silently():
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'hidden'"):
        Synthetic(hidden=["runout"]).measure(PROBLEM, TRUTH, np.random.default_rng(0))


# Inside a run.

CHOSEN = {
    "problem": {"name": "three_disk"},
    "surrogate": {"name": "none"},
    "optimizer": {"name": "lm"},
    "method": {"name": "direct"},
    "study": {"name": "identify"},
}


def test_a_setup_measures_and_tells_what_it_hid():
    draw = Draw(component_seeds(0, 4))
    hiding = Setup.of(CHOSEN | {"measurement": {"name": "synthetic", "kind": "complex", "hidden": ["mass"]}})
    plain = Setup.of(CHOSEN | {"measurement": {"name": "synthetic", "kind": "complex"}})
    assert plain.hidden(draw) == () and [each.effect for each in hiding.hidden(draw)] == ["mass"]
    assert np.array_equal(hiding.measure(draw).values, hiding.true_response(draw))
    assert not np.allclose(plain.measure(draw).values, hiding.measure(draw).values, rtol=1e-6)
    assert hiding.truth == plain.truth and hiding.problem.parameters == plain.problem.parameters


def test_code_of_effects_belongs_to_what_a_result_is_computed_by():
    settings = CHOSEN | {"measurement": {"name": "synthetic"}}
    plain, hiding = used_modules(settings), used_modules(settings | {"parts": ["effect=mass"]})
    assert "problems.effects.mass" not in plain and {
        "problems.effects.mass",
        "problems.rotor.extension.extended",
    } <= set(hiding)
    assert code_digest(plain) != code_digest(hiding)


SEARCH = ["method=direct", "optimizer=lm", "optimizer.screening=500", "optimizer.starts=1", "study.intervals=none"]
SMALL = [*SEARCH, "measurement.kind=complex", "measurement.relative=0.05"]


def test_a_run_records_what_its_data_hide(enter):
    words = ["measurement.hidden=[runout,mass]", "measurement.sizes.mass_change=2", "measurement.phase_known=false"]
    ended = enter(*SMALL, *words, "repetitions=2")
    assert ended.code == 0, ended.err
    first, second = (event["hidden"] for event in ended.events())
    assert [each["effect"] for each in first] == ["runout", "mass"] == [each["effect"] for each in second]
    assert first[0]["parameters"] != second[0]["parameters"]
    assert first[1]["parameters"][0]["value"] == pytest.approx(2.0)
    [cell] = ended.cells()
    assert cell["settings"]["parts"] == ["effect=mass", "effect=runout"]
    assert [facts["name"] for facts in cell["parameters"]][-1] == "phase_origin"


def test_an_extended_problem_is_identified_from_any_directory(enter, tmp_path):
    (tmp_path / "mine.yaml").write_text(
        "problem: {name: three_disk, sensors: [0.1, 0.2]}\neffects:\n  - {name: runout, position: 0.1}\n"
        "reference: {runout_x: 8, runout_y: -3}\n"
    )
    ended = enter(*SMALL, "problem=extended", "problem.file=mine.yaml", "repetitions=1")
    assert ended.code == 0, ended.err
    [cell] = ended.cells()
    assert {facts["name"]: facts["truth"] for facts in cell["parameters"]}["runout_x"] == pytest.approx(8e-6)
    assert cell["settings"]["fingerprint"] and "problem=three_disk" in cell["settings"]["parts"]
    assert all(facts["crlb"] > 0 for facts in cell["parameters"])


def test_identifiability_works_on_an_extended_problem(enter, tmp_path):
    (tmp_path / "mine.yaml").write_text("problem: {name: three_disk}\neffects: [{name: runout, position: 0.1}]\n")
    words = ["+experiment=identifiability", "problem=extended", "problem.file=mine.yaml", "measurement.kind=complex"]
    ended = enter(*words, "measurement.relative=0.05", "repetitions=1", output="results/identifiability")
    assert ended.code == 0, ended.err
    assert "runout_x" in ended.out


def test_help_on_effects(enter):
    page = enter("help", "effect", "runout")
    assert page.code == 0 and "effect.position=null" in page.out and "unknown runout_x: -50 to 50 µm" in page.out
    assert "can look like residual_bow" in page.out and "API 684" in page.out
    everything, names = enter("help", "effect").out, enter("help").out
    for name in registry.registered("effect"):
        assert f"effect={name}: " in everything and name in names
    assert enter("help", "effect", "runot").err.startswith("error: unknown effect 'runot'; did you mean 'runout'?")


@pytest.mark.parametrize("size", ["-5", "1e6"])
def test_a_size_that_is_not_physical_is_refused(enter, cheapest, size):
    words = ["measurement.kind=complex", "measurement.hidden=[flexible_pedestal]", "repetitions=1", "workers=1"]
    ended = enter(*cheapest, *words, f"measurement.sizes={{pedestal_compliance_x:{size}}}")
    assert ended.code == 2 and ended.err.count("\n") == 1
    # 0.2 mm of sag under the rotor's weight of 0.958 kN
    assert "expected pedestal_compliance_x from 0 to 208.851 µm/kN, which is physical" in ended.err


@pytest.mark.parametrize("words", [[], ["+experiment=identify", "measurement=synthetic", "output=results/run"]])
def test_what_data_hide_is_told_below_an_identification_of_them(enter, words):
    ended = enter(*words, *SMALL, "measurement.hidden=[mass]", "measurement.sizes.mass_change=2", "repetitions=1")
    assert ended.code == 0, ended.err
    found, _, hidden = ended.out.partition("\n\nHidden in these synthetic data (not seen by the identification):\n")
    assert hidden.startswith("  mass (whole rotor): mass_change = 2 %\n\n") and "mass" not in found
    assert ended.runs()["hidden_values"].tolist() == ["mass (whole rotor): mass_change = 2 %"]
