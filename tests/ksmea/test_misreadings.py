"""Data that were given as something else are recognised, and data that were not are left alone.

All data are made on a finer mesh by the dense solver; the reading that hides in them is not known to what looks for it.
"""

import dataclasses
import re

import numpy as np
import pytest

import ksmea
from ksmea.errors import SettingError
from ksmea.fits.fitting import Fit
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.problem.counted import Model
from ksmea.show.diagnosis_text import text as diagnosis_text
from ksmea.show.identification_text import text
from ksmea.studies import misreadings as module
from ksmea.studies.misreadings import misreadings
from optimizers.lm import LM
from problems.three_disk import ThreeDisk
from tiers import mostly_slow

TRUTH = {"kxx": 50e6, "kyy": 70e6, "cxx": 500.0, "cyy": 700.0, "u": 2e-4, "phase_origin": 0.6}
NOISE = Noise(0.06, 1e-7)
FAST = {"optimizer": LM(screening=1000, starts=3), "intervals": "information"}
UNBALANCE_KNOWN = {"u": [190.0, 210.0]}  # to 5 %: a factor of the amplitudes is then no other unbalance


def problem(kind="complex", **settings):
    built = ThreeDisk(n_speed=27, **settings).build()
    return built.with_phase_origin() if kind == "complex" else built


def measured(kind="complex", effect=None, seed=1, **settings):
    """A measurement, its noise unknown; with an effect, of a location and size that the seed draws."""
    rng = np.random.default_rng([seed, 5])
    fine = problem(kind, mesh=26, **settings)
    made, size = fine, np.empty(0)
    if effect is not None:
        locations = registry.create("effect", effect, {}).locations(fine)
        located = locations[rng.integers(len(locations))]
        made, size = located.added_to(fine), located.draw(fine, rng)
    x = np.append([TRUTH[name] for name in fine.parameters.names], size)
    values = observe(made.dense_response(x[None])[0], kind, NOISE, rng)
    return Measurement(fine.speed, fine.channels, values, None, "run.csv", phase_known=False)


def middle(rotor):
    return rotor.parameters.to_si(np.full(len(rotor.parameters), 0.5))


def looked_at(rotor, data):
    """Text on data whose fit has been rejected, wherever that fit was."""
    return misreadings(Case(aligned(rotor, data), data), middle(rotor), NOISE, rejected=True)


def with_values(change):
    return lambda data: dataclasses.replace(data, values=change(data.values))


def with_speed(factor):
    return lambda data: dataclasses.replace(data, speed=factor * data.speed)


def swapped(data):
    across = tuple(Channel(each.position, "y" if each.direction == "x" else "x") for each in data.channels)
    return dataclasses.replace(data, channels=across)


REVERSED = "the phases of x at 0.1 m or else of y at 0.1 m are turned by 180°"
SWAPPED = "x and y are swapped, or the shaft turns from y to x"
LAG = "phases are lags where leads are expected"
GIVEN = {  # what is done to the data, the problem's settings, and what must be said of them
    "lag": (with_values(np.conj), {}, [LAG, "change the sign of all phases (phase_lead_deg)"]),
    "x reversed": (with_values(lambda y: y * [-1, 1]), {}, [REVERSED, SWAPPED, "add 180° to these"]),
    "y reversed": (with_values(lambda y: y * [1, -1]), {}, [REVERSED, SWAPPED]),
    "swapped": (swapped, {}, [SWAPPED, "exchange x and y (direction)"]),
    "mil": (with_values(lambda y: y / 25.4), {}, ["amplitudes are in mil where µm are expected (× 25.4)"]),
    "mil, peak to peak": (
        with_values(lambda y: y / 12.7),
        {},
        ["in mil peak to peak where µm 0-peak are expected (× 12.7)"],
    ),
    "converted twice": (with_values(lambda y: y * 25.4), {}, ["converted from mil though they were in µm (× 0.03937)"]),
    "peak to peak": (with_values(lambda y: y * 2), UNBALANCE_KNOWN, ["peak to peak where 0-peak is expected (× 0.5)"]),
    "halved": (with_values(lambda y: y / 2), UNBALANCE_KNOWN, ["halved though they were 0-peak (× 2)"]),
    "rms": (with_values(lambda y: y / np.sqrt(2)), UNBALANCE_KNOWN, ["rms where 0-peak is expected (× 1.414)"]),
    "from rms": (with_values(lambda y: y * np.sqrt(2)), UNBALANCE_KNOWN, ["converted from rms though", "(× 0.7071)"]),
    "lag, peak to peak": (
        with_values(lambda y: 2 * np.conj(y)),
        UNBALANCE_KNOWN,
        [LAG, "peak to peak where 0-peak is expected (× 0.5)"],
    ),
    "Hz as rpm": (with_speed(1 / 60), {}, ["speeds are in Hz where rpm are expected (× 60)", "multiply speed_rpm"]),
    "rad/s as rpm": (with_speed(np.pi / 30), {}, ["speeds are in rad/s where rpm are expected (× 9.549)"]),
    "Hz as rad/s": (with_speed(1 / (2 * np.pi)), {}, ["speeds are in Hz where rad/s are expected (× 6.283)"]),
    "rpm as rad/s": (with_speed(30 / np.pi), {}, ["speeds are in rpm where rad/s are expected (× 0.1047)"]),
    "lag in mil": (with_values(lambda y: y.conj() / 25.4), {}, [LAG, "amplitudes are in mil where", "(× 25.4)"]),
}


@pytest.mark.parametrize("name", GIVEN)
def test_how_the_data_were_given_is_recognised(name):
    change, limits, said = GIVEN[name]
    settings = {"limits": limits} if limits else {}
    [remark] = looked_at(problem(**settings), change(measured()))
    assert remark.startswith("the data look as if ") and all(part in remark for part in said), remark
    left = float(re.search(r"leaves (\d+) % noise", remark)[1])
    assert 5 <= left <= 12  # 6 % and a floor beside it


def test_a_bad_fit_is_looked_at():
    found = ksmea.identify(problem(), with_speed(1 / 60)(measured()), **FAST)
    [remark] = found.record.data.remarks  # one, and none on the band of speeds beside it
    assert "speeds are in Hz where rpm are expected" in remark and text(found.record).count(remark) == 1


def test_one_reversed_probe_among_several_is_named():
    data = measured(sensors=[0.1, 0.5])
    data = with_values(lambda y: y * [1, 1, 1, -1])(data)
    [remark] = looked_at(problem(sensors=[0.1, 0.5]), data)
    assert "as if the phases of y at 0.5 m are turned by 180°: read so" in remark


SWAPPED_THERE = "x and y are swapped at 0.5 m alone"
OF_A_PLANE = {  # the order and the signs of four columns, and what must be said of them
    "reversed": (
        [0, 1, 2, 3],
        [1, 1, -1, -1],
        ["x at 0.1 m, y at 0.1 m or else of x at 0.5 m, y at 0.5 m are turned by 180°"],
    ),
    "swapped": ([0, 1, 3, 2], [1, 1, 1, 1], [SWAPPED_THERE, "exchange these two columns"]),
    "a quarter turn on": ([0, 1, 3, 2], [1, 1, -1, 1], [f"{SWAPPED_THERE}, and y is turned by 180°", "add 180° to y"]),
}


@pytest.mark.parametrize("name", OF_A_PLANE)
def test_probes_of_one_plane_that_are_swapped_or_reversed_are_said_to_be(name):
    order, signs, said = OF_A_PLANE[name]
    data = with_values(lambda y: y[:, order] * signs)(measured(sensors=[0.1, 0.5]))
    [remark] = looked_at(problem(sensors=[0.1, 0.5]), data)
    assert all(part in remark for part in said), remark


def test_amplitudes_have_units_too():
    data = with_values(lambda y: y / 25.4)(measured("amplitude"))
    [remark] = looked_at(problem("amplitude"), data)
    assert "amplitudes are in mil where µm are expected" in remark and "phases" not in remark


def test_a_stated_noise_makes_no_difference():
    """The lack-of-fit test rejects; what a reading leaves is estimated."""
    data = measured()
    sigma = Noise(0.0, NOISE.sd(np.abs(data.values)))
    lagging = dataclasses.replace(data, values=data.values.conj(), noise=sigma)
    [remark] = ksmea.identify(problem(), lagging, **FAST).record.data.remarks
    assert LAG in remark


def test_a_factor_that_the_unbalance_can_take_is_not_called_one():
    """Twice the amplitude is twice the unbalance, 400 of at most 500 g mm: nobody can tell."""
    doubled = with_values(lambda y: y * 2)(measured())
    found = ksmea.identify(problem(), doubled, **FAST)
    assert found.record.data.remarks == () and found["u"].value == pytest.approx(400, rel=0.05)
    assert looked_at(problem(), doubled) == ()


@pytest.mark.parametrize(("u", "factor", "is_taken"), [(2e-4, 2.0, True), (2e-4, 25.4, False), (5e-5, 2.0, False)])
def test_only_an_unbalance_inside_its_limits_takes_a_factor(u, factor, is_taken):
    """200 g mm of 50 to 500: twice as much is inside, 25.4 times is not; at its lower limit the data may ask for less."""
    data = measured()
    likelihood = likelihood_of(Case(aligned(problem(), data), data))
    parameters = likelihood.case.problem.parameters
    x = np.array([{**TRUTH, "u": u}[name] for name in parameters.names])
    fit = Fit(likelihood, likelihood.at(likelihood.start(parameters.to_cube(x))))
    assert module._is_taken_by_unbalance(fit, factor) is is_taken


@pytest.mark.parametrize("kind", ["complex", "amplitude"])
@pytest.mark.parametrize("seed", mostly_slow([1, 2], but=[1]))
def test_of_right_data_nothing_is_said_even_if_it_is_asked(kind, seed):
    assert looked_at(problem(kind), measured(kind, seed=seed)) == ()


@pytest.mark.parametrize(
    "effect",
    mostly_slow(["cross_coupling_antisymmetric", "internal_damping", "probe_rotation", "runout"], but=["runout"]),
)
def test_a_wrong_model_is_not_called_a_misreading(effect):
    """Effects that drive whirl, turn probes or add to every datum."""
    assert looked_at(problem(), measured(effect=effect)) == ()


def test_a_good_fit_is_not_looked_at(monkeypatch):
    monkeypatch.setattr(module, "_begun", None)
    assert ksmea.identify(problem(), measured(), **FAST).record.data.remarks == ()
    assert misreadings(Case(problem(), measured()), middle(problem()), None, rejected=True) == ()


def test_the_deviance_holds_the_jacobian_of_a_factor():
    """−2 (ln L(c y) + n ln c) − D(c y) does not depend on c, whatever the model and the noise are."""
    rotor, data, factor = problem(), measured(), 25.4
    other = with_values(lambda y: factor * y)(data)
    one, scaled = (Likelihood(Model(rotor), each) for each in (data, other))
    theta = np.append(np.full(len(rotor.parameters), 0.4), np.log([0.06, 1e-7]))
    constant = -2 * one.log_density(theta) - one.deviance(theta)
    jacobian = scaled.n_residual * np.log(factor)
    assert -2 * (scaled.log_density(theta) + jacobian) - scaled.deviance(theta) == pytest.approx(constant, rel=1e-9)


class SeenAsItIs(ksmea.Problem):
    """A problem that cannot be seen at other speeds or channels."""

    def __init__(self, problem):
        self.parameters, self.speed, self.channels = problem.parameters, problem.speed, problem.channels
        self.response, self._sensitivity = problem.response, problem.sensitivity

    def sensitivity(self, x):
        return self._sensitivity(x)

    def response(self, x):
        raise AssertionError


def test_a_problem_that_is_only_seen_as_it_is_has_fewer_readings():
    rotor = SeenAsItIs(problem())
    with pytest.raises(SettingError):
        rotor.at(rotor.speed, rotor.channels)
    lagging = with_values(np.conj)(measured())
    [remark] = looked_at(rotor, lagging)
    assert LAG in remark


def test_a_diagnosis_says_it_too():
    lagging = with_values(np.conj)(measured())
    rotor = ksmea.load_problem("three_disk")
    found = ksmea.diagnose(rotor, lagging, effects=["channel_gain"])
    assert found.verdict == "misread" and found.record.remarks == ()
    text = diagnosis_text(found.record)
    assert text.startswith(f"The data look as if {LAG}.\n") and "change the sign of all phases" in text
    right = ksmea.diagnose(rotor, measured(), effects=["channel_gain"], screening=512, starts=3)
    assert right.record.remarks == () and "Note" not in diagnosis_text(right.record)
