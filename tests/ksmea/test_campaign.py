"""Several runs of one machine as one problem: against runs that are made by hand, and what they tell together."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

import ksmea
from campaigns import NOISE, TRIAL, TRUTH, layout_of, measured
from ksmea.diagnosis.trials import candidates
from ksmea.errors import SettingError
from ksmea.extended_model import located_yaml
from ksmea.fits.lack_of_fit import residual_statistics
from ksmea.inference.cramer_rao import identifiability
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.campaign import Weight
from ksmea.measurement.noise import Noise
from ksmea.plugins.registry import create
from ksmea.problem.alignment import aligned, require_aligned
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter
from ksmea.records.extension import EffectRecord, ExtensionRecord
from ksmea.units import GRAM_MILLIMETRE
from problems.rotor.finite_elements.data import UnbalancePlane
from problems.rotor.response.unknowns import UnbalanceTarget, Unknown
from problems.three_disk import ThreeDisk

SENSORS = [0.1, 0.5]
FINE = ThreeDisk(mesh=26, sensors=SENSORS).build()
PLAIN = ThreeDisk(sensors=SENSORS).build()
SPEEDS = [np.linspace(200, 1500, 27), np.linspace(300, 1400, 20)]
RUNS = [("bare", ()), ("trial", (TRIAL,))]
LAYOUT = layout_of(PLAIN, SPEEDS, RUNS)
SEEN = aligned(PLAIN, LAYOUT)
X = np.array([TRUTH[name] for name in SEEN.parameters.names])


def with_weight(problem, speed):
    """The trial run by hand: one more plane in the rotor itself."""
    plane = UnbalancePlane(TRIAL.position, TRIAL.magnitude, TRIAL.angle)
    rotor = dataclasses.replace(problem.rotor, unbalance=(*problem.rotor.unbalance, plane))
    return dataclasses.replace(problem, rotor=rotor, speed=speed).with_phase_origin()


def by_hand(problem):
    return [problem.at(SPEEDS[0], problem.channels).with_phase_origin(), with_weight(problem, SPEEDS[1])]


def test_the_rows_are_the_runs_one_after_the_other():
    expected = np.concatenate([run.dense_response(X[None])[0] for run in by_hand(FINE)])
    found = aligned(FINE, LAYOUT).dense_response(X[None])[0]
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    # the same elements in a finer mesh: a few parts in 10⁵ at these speeds, and the weight is 75 % of the unbalance
    np.testing.assert_allclose(SEEN.response(X[None])[0], expected, rtol=2e-3, atol=2e-3 * np.abs(expected).max())


def test_the_sensitivity_is_the_slope_of_the_response():
    step = 1e-6 * SEEN.parameters.width
    for index, size in enumerate(step):
        moved = np.stack([X, X])
        moved[:, index] += np.array([1, -1]) * size
        ahead, behind = SEEN.response(moved)
        slope, found = (ahead - behind) / (2 * size), SEEN.sensitivity(X)[..., index]
        # central differences: rounding of 1e-11 over a step of 1e-6
        np.testing.assert_allclose(found, slope, rtol=1e-4, atol=1e-4 * np.abs(found).max())


def test_the_joint_deviance_is_the_sum_of_those_of_the_runs():
    data = dataclasses.replace(measured(FINE, LAYOUT), noise=NOISE)
    together = Likelihood(Model(SEEN), data)
    u = SEEN.parameters.to_cube(X)
    alone = []
    for problem, rows in zip(by_hand(PLAIN), data.rows):
        run = dataclasses.replace(data.part(np.arange(rows.start, rows.stop)), campaign=None)
        alone.append(Likelihood(Model(problem), run).deviance(u))
    assert together.deviance(u) == pytest.approx(sum(alone), rel=1e-10)


def test_two_runs_tell_at_least_what_each_tells_alone():
    crlb = identifiability(SEEN, X, NOISE, "complex", noise_known=True).crlb
    for problem in by_hand(PLAIN):
        alone = identifiability(problem, X, NOISE, "complex", noise_known=True).crlb
        assert np.all(crlb <= alone * (1 + 1e-9))


def test_a_trial_weight_tells_unbalance_from_stiffness_far_below_resonance():
    """There the response is u Ω² over a stiffness: one run has their ratio alone, a known weight adds the stiffness."""
    far_below, one_plane = np.linspace(20, 100, 12), ThreeDisk().build()

    def crlb_of_unbalance(runs):
        seen = aligned(one_plane, layout_of(one_plane, [far_below] * len(runs), runs))
        found = identifiability(seen, X, Noise(0.01, 4e-9), "complex", noise_known=True).crlb
        return found[seen.parameters.names.index("u")]

    u = PLAIN.parameters.items[PLAIN.parameters.names.index("u")]
    assert crlb_of_unbalance(RUNS[:1]) > u.upper - u.lower  # not identifiable within its limits
    assert crlb_of_unbalance(RUNS) < 0.15 * TRUTH["u"]


def test_runs_may_have_unknowns_of_their_own():
    own = layout_of(PLAIN, SPEEDS, RUNS, own=("u",))
    seen = aligned(PLAIN, own)
    assert seen.parameters.names == ("kxx", "kyy", "cxx", "cyy", "u@bare", "u@trial", "phase_origin")
    x = np.insert(X, 5, X[4])
    np.testing.assert_allclose(seen.response(x[None]), SEEN.response(X[None]), rtol=1e-12)
    x[5] *= 2  # of the trial run alone
    changed = seen.response(x[None])[0]
    bare, trial = LAYOUT.rows
    np.testing.assert_allclose(changed[bare], SEEN.response(X[None])[0][bare], rtol=1e-12)
    assert np.all(np.abs(changed[trial] - SEEN.response(X[None])[0][trial]) > 0)
    slopes = seen.sensitivity(x)
    assert not np.any(slopes[trial, :, 4]) and not np.any(slopes[bare, :, 5])
    made = measured(FINE, own, TRUTH | {"u@bare": 2e-4, "u@trial": 2.6e-4})
    likelihood = Likelihood(Model(seen), dataclasses.replace(made, noise=NOISE))
    found = maximise(likelihood, likelihood.start(seen.parameters.to_cube(np.insert(X, 5, X[4]))))
    u = seen.parameters.to_si(found.theta)[4:6]
    sd = seen.parameters.width[4:6] * np.sqrt(np.diag(np.linalg.inv(found.information))[4:6])
    assert np.all(np.abs(u - [2e-4, 2.6e-4]) < 4 * sd)  # one draw in ten thousand is farther off
    assert np.all(sd < 2e-6)


def test_an_effect_is_added_in_all_runs_with_shared_unknowns():
    runout = create("effect", "runout", {"position": 0.5})
    extended = runout.added_to(SEEN)
    assert extended.parameters.names == (*SEEN.parameters.names, "runout_x", "runout_y")
    x = np.append(X, [2e-6, -1e-6])
    expected = np.concatenate([runout.added_to(run).response(x[None])[0] for run in by_hand(PLAIN)])
    np.testing.assert_allclose(extended.response(x[None])[0], expected, rtol=1e-9)


def test_an_effect_is_the_same_in_runs_of_other_bands():
    """An effect that changes with speed does so relative to the highest of all runs, not of each."""
    low = layout_of(PLAIN, [SPEEDS[0], np.linspace(200, 600, 9)], RUNS)
    extended = create("effect", "speed_dependent_stiffness", {}).added_to(aligned(PLAIN, low))
    at_full = create("effect", "speed_dependent_stiffness", {"full_speed": 1500.0})
    run = at_full.added_to(with_weight(PLAIN, np.linspace(200, 600, 9)))
    x = np.append(X, 0.3)
    np.testing.assert_allclose(extended.response(x[None])[0][low.rows[1]], run.response(x[None])[0], rtol=1e-9)


def test_all_effects_have_the_locations_that_they_have_on_the_machine():
    effects = {name: create("effect", name, {}) for name in ksmea.plugins.registry.registered("effect")}
    found = [(each.name, str(each.effect)) for each in candidates(SEEN, effects)]
    assert found == [(each.name, str(each.effect)) for each in candidates(PLAIN.with_phase_origin(), effects)]


def test_angles_of_weights_leave_the_origin_of_phases_unknown():
    """Where all phases of the unbalance are unknown they stand for the origin too; a weight of known angle does not turn."""
    free = _free(PLAIN)
    repeats = layout_of(free, SPEEDS, [("one", ()), ("two", ())])
    assert "phase_origin" not in aligned(free, repeats).parameters.names
    seen = aligned(free, LAYOUT)
    assert "phase_origin" in seen.parameters.names
    turned = np.insert(X, 5, 0.2)  # the unbalance by 0.2 rad, and all by the origin
    bare, trial = LAYOUT.rows
    response, before = seen.response(turned[None])[0], SEEN.response(X[None])[0]
    np.testing.assert_allclose(response[bare], before[bare] * np.exp(0.2j), rtol=1e-9)
    assert not np.allclose(np.abs(response[trial]), np.abs(before[trial]), rtol=1e-2)


def _free(problem):
    """Rotor with the phase of its unbalance unknown."""
    phase = Unknown(Parameter("phase", "deg", np.pi / 180, -3.0, 3.0), (UnbalanceTarget(0, "phase"),))
    return dataclasses.replace(problem, unknowns=(*problem.unknowns, phase))


def test_a_problem_that_is_not_seen_in_the_runs_is_refused():
    data = measured(FINE, LAYOUT)
    plain = PLAIN.at(data.speed, data.channels).with_phase_origin()
    with pytest.raises(SettingError, match=r"runs: expected 2 runs of one machine.*got a problem seen in one run"):
        require_aligned(plain, data)


@pytest.mark.parametrize(
    "weight, message",
    [
        (Weight(5.0, 1e-4), r"run trial, weight 100 g mm at 5 m, 0°: .*on the shaft"),
        (Weight(1.0, 600_000 * GRAM_MILLIMETRE), "run trial: expected weights up to 500000 g mm.*is it in g mm"),
    ],
)
def test_weights_that_cannot_be_are_refused(weight, message):
    with pytest.raises(SettingError, match=message):
        aligned(PLAIN, layout_of(PLAIN, SPEEDS, [("bare", ()), ("trial", (weight,))]))


def test_an_unknown_of_its_own_has_to_be_one():
    with pytest.raises(SettingError, match=r"unknown in own: 'kxz'; did you mean 'kxx'"):
        aligned(PLAIN, layout_of(PLAIN, SPEEDS, RUNS, own=("kxz",)))


def test_neighbours_of_different_runs_are_no_neighbours():
    """The autocorrelation over speed does not depend on the order of the runs, nor on what the others' ends are."""
    noise = np.random.default_rng(0).standard_normal((5, 20, 2))
    one, other = noise[:, :8], noise[:, 8:]
    ahead = residual_statistics(noise, [slice(0, 8), slice(8, 20)], scale_free=True)
    swapped = residual_statistics(np.concatenate([other, one], axis=1), [slice(0, 12), slice(12, 20)], scale_free=True)
    np.testing.assert_allclose(ahead, swapped, rtol=1e-12)
    joined = residual_statistics(noise, [slice(0, 20)], scale_free=True)
    assert np.all(joined[:, 0] != ahead[:, 0])


def test_an_extended_model_is_of_the_machine(tmp_path):
    """It has one value of what each run had of its own, the first run's, so that it can be read again."""
    effect = EffectRecord("runout", "at 0.5 m", {"position": 0.5})
    values = {
        "weight_x@trial": 9.0,
        "kxx": 50.0,
        "u@bare": 210.0,
        "u@trial": 190.0,
        "phase_origin@bare": 3.0,
        "phase_origin@trial": 4.0,
    }
    values |= {"runout_x": 0.3, "runout_y": -0.2}
    record = SimpleNamespace(extension=ExtensionRecord(effect, values, {}), is_spread=False)
    path = tmp_path / "extended.yaml"
    path.write_text(located_yaml("three_disk", {}, record, ()), encoding="utf-8")
    extended = create("problem", "extended", {"file": str(path)})
    assert extended.reference()["u"] == pytest.approx(210e-6)
    assert {"u", "phase_origin", "runout_x"} <= set(extended.build().parameters.names)
