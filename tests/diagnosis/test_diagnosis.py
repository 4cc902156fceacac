"""Hidden effects are found, right models are left alone, and what is not in the registry is not named."""

import dataclasses

import numpy as np
import pytest

from bench.studies.diagnose import Diagnose
from ksmea.diagnosis.diagnosis import Criteria, diagnose
from ksmea.diagnosis.trials import Candidate, candidates, refined
from ksmea.errors import SettingError
from ksmea.fits.lack_of_fit import fit_quality
from ksmea.fits.search import Search
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from ksmea.studies.diagnose import Report, diagnosis
from problems.effects.local_force import LocalForce
from problems.effects.runout import Runout
from problems.three_disk import ThreeDisk
from tests.diagnosis.conftest import LESS, NOISE, SENSORS, TRUTH, VERDICT, common_effects, registered_effects
from tiers import mostly_slow


def diagnosed(rotor, measurement, effects=None, seed=0, effort=None, **criteria):
    search = Search(np.random.default_rng(seed), effort or LESS)
    return diagnose(Case(rotor, measurement), effects or common_effects(), search, Criteria(**criteria))


@pytest.mark.parametrize("seed", mostly_slow(range(6), but=[0]))
def test_a_right_model_is_adequate(rotor, hide, seed):
    """A false alarm has a chance of 1 % in each: seeds were not chosen."""
    measurement, _, _ = hide(None, seed)
    found = diagnosed(rotor, measurement, registered_effects())
    assert found.verdict == "adequate"
    assert found.named == found.ambiguity_group == () and found.best is None and found.predictive_gain is None
    # the baseline model's values are those of the finer one but for noise: 5 σ
    sd = [(interval.high - interval.low) / 3.92 for interval in found.baseline_estimate.intervals[:2]]
    assert abs(found.baseline.x[:2] - [50e6, 70e6]) == pytest.approx(0, abs=5 * max(sd))


# effects of every kind of hook; rates of all are in results/reference/diagnosis_effects.csv
@pytest.mark.parametrize(
    ("name", "seed"),
    mostly_slow(
        [
            ("runout", 1),
            ("unbalance", 2),
            ("youngs_modulus", 3),
            ("cross_coupling_symmetric", 4),
            ("channel_gain", 5),
            ("speed_dependent_stiffness", 11),
        ],
        but=["runout"],
    ),
)
def test_a_hidden_effect_is_named_with_its_size(rotor, hide, name, seed):
    """One among all that are registered, the others among what looks like them and three common causes."""
    measurement, located, size = hide(name, seed)
    found = diagnosed(rotor, measurement, registered_effects() if name == "channel_gain" else with_its_like(name))
    trial = next(trial for trial in found.trials if trial.candidate == Candidate(name, located))
    assert trial.deviance_drop >= 60, "the draw is too small to be asked for"
    assert found.verdict in ("named", "ambiguous") and name in found.ambiguity_group
    assert found.best_quality.p > found.level / 2 and found.predictive_gain.elpd.total > 0
    if name in found.named:
        assert found.applied[0].effect == located
        intervals = found.best_estimate.intervals[len(rotor.parameters) :]
        for value, interval in zip(size, intervals):  # 95 %, widened to twice their half-width: 99.99 %
            middle, half = (interval.low + interval.high) / 2, interval.high - interval.low
            assert abs(value - middle) < half


def with_its_like(name):
    """The effect, the common ones that look like it, and three others."""
    names = (name, *registry.create("effect", name, {}).aliases, "channel_gain", "runout", "unbalance")
    return {each: effect for each, effect in common_effects().items() if each in names}


def test_effects_that_are_the_same_are_ambiguous_and_said_to_be(rotor, hide):
    """More mass throughout is less stiffness throughout, with other bearings and unbalance."""
    measurement, _, _ = hide("mass", 11)
    found = diagnosed(rotor, measurement, few("mass", "youngs_modulus", "channel_gain", "unbalance"))
    assert found.verdict == "ambiguous" and {"mass", "youngs_modulus"} <= set(found.ambiguity_group)
    other = "youngs_modulus" if found.named == ("mass",) else "mass"
    assert found.collinearity[other] > 0.999


@pytest.mark.slow
def test_what_is_not_in_the_registry_is_unknown_or_a_known_alias(rotor, hide):
    """Without runout in the library no effect is constant over speed, and none must be named with confidence, however hard it is
    looked for."""
    whole, _, size = hide("runout", 21)
    assert np.hypot(*size) > 3e-7  # three times the floor: clearly visible
    measurement = whole.part(np.arange(0, len(whole.speed), 2))
    found = diagnosed(
        rotor.at(measurement.speed, measurement.channels), measurement, common_effects("runout"), effort=VERDICT
    )
    assert found.verdict == "unknown"
    assert found.named == () and found.ambiguity_group == ()


@pytest.mark.slow
def test_effects_are_scanned_at_all_effort_only_where_little_leaves_more_than_noise(rotor, hide, monkeypatch):
    made = []

    def noted(trials, baseline, search, *is_enough):
        made.append((search.effort.scan, search.effort.scan_clouds))
        return refined(trials, baseline, search, *is_enough)

    monkeypatch.setattr("ksmea.diagnosis.diagnosis.refined", noted)
    effort = dataclasses.replace(LESS, scan=100, scan_clouds=40)
    measurement, _, _ = hide("channel_gain", 1)
    known = {name: effect for name, effect in common_effects().items() if name in ("channel_gain", "runout")}
    assert "channel_gain" in diagnosed(rotor, measurement, known, effort=effort).named
    assert made == [(25, 10)]
    made.clear()
    assert diagnosed(rotor, measurement, {"runout": known["runout"]}, effort=effort).verdict == "unknown"
    assert made == [(25, 10), (100, 40)]


def test_two_effects_at_once_are_named_together():
    rotor, fine = (ThreeDisk(mesh=mesh, sensors=SENSORS, n_speed=27).build().with_phase_origin() for mesh in (13, 26))
    effects = common_effects()
    runout = effects["runout"].locations(fine)[1]
    gain = effects["channel_gain"].locations(fine)[-1]
    problem = gain.added_to(runout.added_to(fine))
    x = np.array([*(TRUTH[name] for name in fine.parameters.names), 1e-6, 1e-6, 0.15])
    values = observe(problem.dense_response(x[None])[0], "complex", Noise(0.05, 5e-8), np.random.default_rng(5))
    measurement = Measurement(fine.speed, fine.channels, values, None, "test")
    effects = few("channel_gain", "probe_rotation", "residual_bow", "runout", "unbalance", "unequal_bearings")
    found = diagnosed(rotor, measurement, effects)
    assert found.verdict == "named" and set(found.named) == {"runout", "channel_gain"}


@pytest.mark.parametrize("seed", mostly_slow([1, 2, 3], but=[1]))
def test_a_second_effect_that_only_shows_in_its_own_fit_is_named_too(rotor, seed):
    """A gain so small that what a runout alone leaves could be noise: as with a first effect, its own fit is significant."""
    fine = ThreeDisk(mesh=26, sensors=SENSORS).build().with_phase_origin()
    effects = common_effects()
    runout, gain = effects["runout"].locations(fine)[1], effects["channel_gain"].locations(fine)[0]
    problem = gain.added_to(runout.added_to(fine))
    x = np.array([*(TRUTH[name] for name in fine.parameters.names), 1e-6, 1e-6, 0.05])
    values = observe(problem.dense_response(x[None])[0], "complex", Noise(0.05, 5e-8), np.random.default_rng(seed))
    measurement = Measurement(fine.speed, fine.channels, values, None, "test")
    found = diagnosed(rotor, measurement, few("runout", "channel_gain", "unbalance"))
    alone = fit_quality(found.trials[0].fit, np.random.default_rng(0))
    assert found.trials[0].name == "runout" and alone.p > found.level / 2
    assert set(found.named) == {"runout", "channel_gain"} and gain in [each.effect for each in found.applied]


@pytest.mark.slow
def test_an_effect_that_explains_the_data_as_well_is_reported_however_many_unknowns_it_has(rotor, hide):
    """A mass on a stiff spring does as much as one on the shaft, but has three unknowns for it: BIC would leave it out, and the data hold
    no evidence against it."""
    measurement, _, _ = hide("added_mass", 24)
    found = diagnosed(rotor, measurement, few("added_mass", "spring_mass", "runout"))
    rigid, sprung = (
        next(trial for trial in found.trials if trial.name == name) for name in ("added_mass", "spring_mass")
    )
    assert rigid.delta_bic - sprung.delta_bic > 6 and rigid.deviance_drop - sprung.deviance_drop < 6
    assert found.named == ("added_mass",) and "spring_mass" in found.ambiguity_group
    assert found.collinearity["spring_mass"] > 0.99


def test_without_a_critical_speed_in_band_little_is_observable():
    """In rpm the band is quasi-static: most effects would not show even at their physical limits."""
    problem = ThreeDisk(reading="rpm", sensors=[0.1]).build()
    x = np.array([TRUTH[name] for name in problem.parameters.names])
    values = observe(problem.dense_response(x[None])[0], "amplitude", Noise(0.1, 1e-8), np.random.default_rng(1))
    measurement = Measurement(problem.speed, problem.channels, values, None, "test")
    found = diagnosed(problem, measurement)
    assert found.verdict == "not observable"
    beyond = [name for name, (_, parts) in found.detectable.items() if not any(part.is_observable for part in parts)]
    assert len(beyond) > len(found.detectable) / 2


def test_amplitudes_of_one_channel_and_uneven_speeds_can_be_diagnosed():
    speed = np.sort(np.random.default_rng(0).uniform(200, 1500, 90))
    fine = ThreeDisk(mesh=26).build().at(speed, [Channel(0.2, "x")])
    x = np.array([TRUTH[name] for name in fine.parameters.names])
    values = observe(fine.dense_response(x[None])[0], "amplitude", Noise(0.05, 1e-8), np.random.default_rng(3))
    measurement = Measurement(fine.speed, fine.channels, values, None, "test")
    found = diagnosed(ThreeDisk().build().at(speed, [Channel(0.2, "x")]), measurement)
    assert found.verdict in ("adequate", "not observable")


@pytest.mark.slow
def test_the_same_seed_gives_the_same_diagnosis(rotor, hide):
    measurement, _, _ = hide("unbalance", 2)
    effects = few("channel_gain", "mass", "runout", "unbalance")
    one, other = (diagnosed(rotor, measurement, effects, seed=4) for _ in range(2))
    assert [trial.deviance_drop for trial in one.trials] == [trial.deviance_drop for trial in other.trials]
    assert one.baseline_quality.p == other.baseline_quality.p


def few(*names):
    return {name: effect for name, effect in registered_effects().items() if name in names}


def test_data_with_a_noise_of_their_own_are_diagnosed(rotor, hide):
    """Known standard deviations datum by datum: named, its gain on left-out blocks, and a split where it is ambiguous."""
    measurement, _, _ = hide("mass", 11)
    sigma = Noise(0.0, NOISE.sd(np.abs(measurement.values)))
    told = dataclasses.replace(measurement, noise=sigma)
    found = diagnosed(rotor, told, few("mass", "youngs_modulus", "runout"))
    assert found.verdict == "ambiguous" and set(found.ambiguity_group) == {"mass", "youngs_modulus"}
    assert found.predictive_gain.elpd.total > 0 and found.baseline_quality.reduced_chi2 > 1.5
    named = diagnosed(rotor, told, few("mass", "runout"))
    assert named.named == ("mass",) and "χ²" in named.baseline_quality.p_by_statistic


@pytest.mark.slow
def test_amplitudes_that_hide_an_effect_are_diagnosed(hide):
    baseline = ThreeDisk(sensors=SENSORS).build()
    fine = ThreeDisk(mesh=26, sensors=SENSORS).build()
    gain = registered_effects()["channel_gain"].locations(fine)[3]
    x = np.array([*(TRUTH[name] for name in fine.parameters.names), 0.15])
    values = observe(gain.added_to(fine).dense_response(x[None])[0], "amplitude", NOISE, np.random.default_rng(8))
    measurement = Measurement(fine.speed, fine.channels, values, None, "test")
    found = diagnosed(baseline, measurement, few("channel_gain", "runout", "unequal_bearings"))
    assert found.named == ("channel_gain",) and found.applied[0].effect == gain


def test_an_extended_problem_can_be_diagnosed_again(rotor, hide):
    """An effect of the problem is not fitted again at its place, and with it the model is adequate."""
    measurement, located, _ = hide("runout", 1)
    extended = located.added_to(rotor)
    tried, before = (
        [each.effect for each in candidates(problem, registered_effects())] for problem in (extended, rotor)
    )
    assert located not in tried and len(tried) == len(before) - 1
    assert diagnosed(extended, measurement, few("channel_gain", "unbalance", "runout")).verdict == "adequate"


def test_rivals_count_though_they_would_not_be_significant_alone(rotor, hide):
    """ΔBIC within 6 of the best is ambiguous whatever the p of the second."""
    measurement, _, _ = hide("cross_coupling_antisymmetric", 3)
    found = diagnosed(rotor, measurement, few("cross_coupling_antisymmetric", "internal_damping"))
    lead, other = found.trials
    assert ("internal_damping" in found.ambiguity_group) == (
        lead.delta_bic - other.delta_bic < 6 or lead.deviance_drop - other.deviance_drop < 6
    )


def test_a_location_that_is_not_certain_is_said_to_be(rotor):
    """One probe of a pair with an eighth more gain: small enough that another channel's gain comes near."""
    fine = ThreeDisk(mesh=26, sensors=SENSORS).build().with_phase_origin()
    unbalance = registered_effects()["unbalance"].locations(fine)[0]
    x = np.array([*(TRUTH[name] for name in fine.parameters.names), 8e-6, 0.0])
    values = observe(unbalance.added_to(fine).dense_response(x[None])[0], "complex", NOISE, np.random.default_rng(4))
    measurement = Measurement(fine.speed, fine.channels, values, None, "test")
    found = diagnosed(rotor, measurement, few("unbalance"), level=0.5)
    near = [trial.location for trial in found.trials if trial.delta_bic > found.trials[0].delta_bic - 6]
    assert found.locations == (tuple(near) if found.named else ())


def test_effects_of_which_none_has_a_place_are_refused(rotor, hide):
    with pytest.raises(SettingError, match="expected effects"):
        diagnose(Case(rotor, hide(None, 0)[0]), {"local_force": LocalForce()}, Search(np.random.default_rng(0)))


class Unfitting(Runout):
    """An effect for problems of another kind."""

    def added_to(self, problem):
        return problem.no_such_thing


def test_an_effect_that_does_not_fit_the_problem_is_left_out_and_named(rotor, hide):
    measurement, _, _ = hide(None, 0)
    effects = {"mine": Unfitting(), **few("runout")}
    one, other = diagnosed(rotor, measurement, effects), diagnosed(rotor, measurement, few("runout"))
    assert list(one.left_out) == ["mine"] and other.left_out == {}
    assert one.left_out["mine"].startswith("does not fit this problem: AttributeError: ")
    assert [trial.deviance_drop for trial in one.trials] == [trial.deviance_drop for trial in other.trials]


def test_an_effect_that_cannot_be_loaded_is_left_out_and_named(rotor, hide, tmp_path, monkeypatch):
    (tmp_path / "broken_effect.py").write_text("import a_module_that_nobody_has\n")
    information = tmp_path / "broken_effect-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: broken-effect\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text("[ksmea.effects]\naaa_broken = broken_effect:Broken\n")
    registry.registered.cache_clear()
    with monkeypatch.context() as patched:
        patched.syspath_prepend(tmp_path)
        made, left_out = registry.create_all("effect", registry.registered("effect"))
        n_part = len(Diagnose().parts)
        with pytest.raises(SettingError, match="cannot be loaded"):
            _ = Diagnose(effects=["aaa_broken"]).parts
    registry.registered.cache_clear()
    assert "runout" in made and n_part == len(made)
    assert list(left_out) == ["aaa_broken"]
    record = diagnosis(
        Case(rotor, hide(None, 0)[0]), few("runout"), np.random.default_rng(0), report=Report(left_out=left_out)
    )
    assert record.left_out["aaa_broken"].startswith(
        "effect=aaa_broken: broken_effect:Broken cannot be loaded: ModuleNot"
    )
