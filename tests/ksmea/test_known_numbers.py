"""Influence of numbers known to a tolerance on the precision of data.

It is compared with marginal covariances, limits, and priors that count once.
"""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import ksmea
from ksmea.fits.fitting import Fit
from ksmea.inference.cramer_rao import identifiability, joint_sensitivity
from ksmea.inference.known_numbers import Numbers, own_numbers_as_noise, prior_data
from ksmea.inference.optimal_design import crlb, data_rows
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.measurement.channel import Channel
from ksmea.measurement.noise import Noise
from ksmea.problem.case import Case
from ksmea.problem.parameters import Parameter, Parameters, Prior
from ksmea.problem.problem import Problem, joint_values
from ksmea.records.identifiability import IdentifiabilityRecord
from ksmea.records.planning import PlanningRecord
from ksmea.show import identifiability_text, planning_text
from ksmea.show.charts.identifiability_chart import identifiability_chart
from ksmea.show.charts.planning_chart import planning_chart
from ksmea.studies.design_point import DesignPoint
from ksmea.studies.identifiability import IdentifiabilityOptions, identifiability_of, identifiability_study, varied_data
from ksmea.studies.inputs import input_records
from ksmea.studies.planning import PlanningOptions, planning_study

ROTOR = Path("docs/examples/rotor.yaml")
NOISE = Noise(0.05, 1e-7)
KINDS = ("young_modulus", "density", "mass", "inertia", "probe_position", "gain", "plane_gain", "direction")


class Linear(Problem):
    """y = A x + B b at each speed, with numbers b of very different sizes: of Young's modulus, of a position, of a gain."""

    channels = (Channel(0.0, "x"),)
    speed = np.arange(1.0, 13.0)
    sizes = np.array([2e11, 1e-1, 1.0])
    sd = np.array([4e9, 3e-3, 0.02])

    def __init__(self, is_joint=False):
        rng = np.random.default_rng(5)
        self.own = rng.standard_normal((12, 2)) + 1j * rng.standard_normal((12, 2))
        # per sd of a number these are as large as the noise
        self.of_numbers = (rng.standard_normal((12, 3)) + 1j * rng.standard_normal((12, 3))) / self.sd
        items = tuple(Parameter(f"a{n}", "1", 1.0, -5.0, 5.0) for n in (1, 2))
        numbers = tuple(
            Parameter(f"b{n}", "1", 1.0, size - 6 * sd, size + 6 * sd, prior=Prior(size, sd), is_input=True)
            for n, (size, sd) in enumerate(zip(self.sizes, self.sd), start=1)
        )
        self.is_joint, self.parameters = is_joint, Parameters(items + numbers if is_joint else items)

    @property
    def joint(self):
        return self if self.is_joint else Linear(is_joint=True)

    def response(self, x):
        numbers = x[:, 2:] if self.is_joint else np.tile(self.sizes, (len(x), 1))
        return (x[:, :2] @ self.own.T + (numbers - self.sizes) @ self.of_numbers.T)[..., None]

    def sensitivity(self, x):
        return (np.hstack([self.own, self.of_numbers]) if self.is_joint else self.own)[:, None]


def marginal(exact=()):
    """CRLB (2,) by the covariance Σ + G S Gᵀ of real and imaginary parts whose noise has a variance of 1 each."""
    problem, kept = Linear(), [index for index in range(3) if f"b{index + 1}" not in exact]
    columns, g = (np.vstack([part.real, part.imag]) for part in (problem.own, problem.of_numbers[:, kept]))
    covariance = np.eye(24) + (g * problem.sd[kept] ** 2) @ g.T
    return np.sqrt(np.diag(np.linalg.inv(columns.T @ np.linalg.solve(covariance, columns))))


@pytest.fixture(scope="module")
def rotor_with(tmp_path_factory):
    """The rotor of the example with a line on tolerances."""

    def made(line, was="", now=""):
        path = tmp_path_factory.mktemp("rotor") / "rotor.yaml"
        path.write_text(f"{ROTOR.read_text().replace(was, now) if was else ROTOR.read_text()}\n{line}\n")
        return ksmea.load_problem(str(path))

    return made


@pytest.fixture(scope="module")
def typical(rotor_with):
    return rotor_with("tolerances: typical")


def point_of(rotor, noise=NOISE, **changes):
    return DesignPoint(rotor.problem, rotor.x(), noise, "amplitude", **changes)


# -- identifiability --


@pytest.mark.parametrize("exact", [(), ("b1",), ("b2", "b3"), ("b1", "b2", "b3")], ids=str)
def test_a_prior_on_a_number_is_noise_of_the_marginal_covariance(exact):
    """Complex noise of √2 has a variance of 1 in each part."""
    problem, noise = Linear(), Noise(0.0, np.sqrt(2))
    found = identifiability(problem, np.array([1.0, 2.0]), noise, "complex", exact=exact)
    assert found.crlb == pytest.approx(marginal(exact), rel=1e-9)


def test_numbers_of_any_size_widen_intervals_of_a_rotor_as_the_inverse_says(typical):
    """Young's modulus is 1e11 and a position 0.1 in SI: neither may be lost beside the other."""
    problem, x = typical.problem, typical.x()
    joint = problem.joint
    width = joint.parameters.width
    whitened = joint_sensitivity(joint, joint_values(problem, joint, x), NOISE, "amplitude") * width
    expected = np.sqrt(np.diag(np.linalg.inv(whitened.T @ whitened)))[:5] * width[:5]
    assert identifiability(problem, x, NOISE, "amplitude").crlb == pytest.approx(expected, rel=1e-6)


def test_with_all_numbers_exact_it_is_the_rotor_as_stated(typical, rotor_with):
    found = identifiability_of(point_of(typical, exact=Numbers.of(typical.problem).names)).crlb
    # another reduction of the same rotor
    assert found == pytest.approx(identifiability_of(point_of(rotor_with(""))).crlb, rel=1e-5)


def test_numbers_known_next_to_exactly_change_next_to_nothing(rotor_with):
    tiny = ", ".join(f"{kind}: 1e-8" for kind in KINDS if kind not in ("probe_position", "direction"))
    almost = rotor_with(f"tolerances: {{{tiny}, probe_position: 1e-9, direction: 1e-6}}")
    assert len(Numbers.of(almost.problem)) > 10
    exact = identifiability_of(point_of(rotor_with(""))).crlb
    assert identifiability_of(point_of(almost)).crlb == pytest.approx(exact, rel=1e-5)


def test_tolerances_of_zero_change_no_bit(rotor_with):
    none = rotor_with(f"tolerances: {{{', '.join(f'{kind}: 0' for kind in KINDS)}}}")
    records = [
        [
            identifiability_study(point_of(rotor)).to_data(),
            planning_study(point_of(rotor), PlanningOptions(n_candidate=20, add=2)).to_data(),
        ]
        for rotor in (none, rotor_with(""))
    ]
    assert records[0] == records[1]


def test_each_number_that_becomes_exact_lowers_crlbs_and_all_of_them_most(typical):
    point = point_of(typical)
    present = identifiability_of(point).crlb
    varied = {
        value: identifiability_of(each).crlb for value, each in varied_data("numbers", point, IdentifiabilityOptions())
    }
    assert len(varied) == 14 and list(varied)[-1] == "all"
    together = varied.pop("all")
    for alone in varied.values():
        assert np.all(alone <= present * (1 + 1e-9)) and np.all(together <= alone * (1 + 1e-9))  # rounding
    # E and density scale all critical speeds alike, as k does
    best = min(varied, key=lambda value: varied[value][0])
    assert best == "density of steel" and varied[best][0] < 0.7 * present[0]


def test_the_record_says_where_a_crlb_comes_from(typical, rotor_with):
    record = identifiability_study(point_of(typical), IdentifiabilityOptions(variations=[]))
    assert len(record.numbers) == 13
    for parameter in record.parameters:
        total = parameter.origin.sd_noise**2 + parameter.origin.sd_inputs**2
        assert np.sqrt(total) == pytest.approx(parameter.crlb, rel=1e-6)
    # noise has the smaller share the less of it there is
    quiet = identifiability_study(point_of(typical, NOISE.scaled(0.1)), IdentifiabilityOptions(variations=[]))
    shares = [[item.origin.of_inputs for item in each.parameters] for each in (record, quiet)]
    assert all(less < more for less, more in zip(*shares))
    exact = identifiability_study(point_of(rotor_with("")), IdentifiabilityOptions(variations=["numbers"]))
    assert not exact.numbers and not exact.variations and all(item.origin is None for item in exact.parameters)


# -- plans --


def test_rows_of_data_and_priors_have_the_crlb_of_the_marginal_covariance():
    problem, x = Linear(), np.array([1.0, 2.0])
    rows = data_rows(problem, x, Noise(0.0, np.sqrt(2)), "complex")
    flat = rows.reshape(-1, rows.shape[-1])
    priors = prior_data(problem.parameters, Numbers.of(problem), flat.shape[1])
    found = crlb(np.vstack([flat, priors]), 2) * problem.parameters.width
    assert found == pytest.approx(marginal(), rel=1e-9)


def test_numbers_that_one_addition_alone_sees_are_its_noise():
    """Columns kept and columns counted as noise know the unknowns equally well; a number that two share is kept."""
    rng = np.random.default_rng(1)
    sd = np.array([0.1, 0.3, 0.05])  # of numbers: of the first block, of the second, of both
    blocks = [rng.standard_normal((6, 5)) for _ in range(2)]
    blocks[0][:, 3] = blocks[1][:, 2] = 0.0
    made, shared = own_numbers_as_noise(blocks, sd)
    assert shared.tolist() == [2] and all(block.shape == (6, 3) for block in made)
    for chosen in ([0], [1], [0, 1]):
        whole = np.vstack([*(blocks[index] for index in chosen), np.hstack([np.zeros((3, 2)), np.diag(1 / sd)])])
        short = np.vstack([*(made[index] for index in chosen), [[0, 0, 1 / sd[2]]]])
        assert crlb(short, 2) == pytest.approx(crlb(whole, 2), rel=1e-12)


@pytest.fixture(scope="module")
def planned(typical):
    options = PlanningOptions(target="kxx", n_candidate=20, add=2, sensors=2, numbers=13, trial_phases=[180.0])
    return planning_study(point_of(typical), options)


def family(record, name):
    [found] = [each for each in record.families if each.family == name]
    return found


def test_the_present_crlbs_are_those_of_identifiability(planned, typical):
    assert planned.crlb == pytest.approx(identifiability_of(point_of(typical)).crlb, rel=1e-6)


def test_a_repeated_run_repeats_no_prior(planned, typical):
    """It is a run of √½ the noise: CRLBs by the numbers stay what they are. Halving all of them would be 29 %."""
    repeated = family(planned, "trial run").steps[0]
    problem, floor = typical.problem, Noise(0.0, 1e-7)
    twice = planning_study(point_of(typical, floor), PlanningOptions(target="kxx", add=0, sensors=0, numbers=1))
    once = identifiability_of(point_of(typical, floor.scaled(np.sqrt(0.5)))).crlb
    assert family(twice, "numbers").steps[0].unplanned_crlb == pytest.approx(once, rel=1e-6)
    assert family(twice, "trial run").steps[0].unplanned_crlb == pytest.approx(once, rel=1e-6)
    assert problem.joint is not problem and 0 < repeated.unplanned_reduction_pct < 5


def test_a_number_that_is_measured_is_as_good_as_exact(planned, typical):
    """Each alone, and the chosen ones step by step: the columns of `identifiability` taken away."""
    found, numbers = family(planned, "numbers"), Numbers.of(typical.problem)
    for index, (item, reached) in enumerate(zip(numbers.items, found.candidates.crlb)):
        exact = identifiability_of(point_of(typical, exact=(item.name,))).crlb[0]
        assert found.candidates.number[index] == item.words
        assert reached == pytest.approx(exact, rel=1e-4)  # it is known 10 000 times as well as stated
    chosen = []
    for step in found.steps:
        chosen.append(numbers.items[step.candidate].name)
        exact = identifiability_of(point_of(typical, exact=tuple(chosen))).crlb
        assert step.crlb == pytest.approx(exact, rel=1e-4)
    assert found.steps[0].number == "density of steel" and len(chosen) == 13


def test_added_probes_bring_their_own_numbers(planned, typical):
    """The rotor measured with the present and the added probes at once, all of their positions, gains and directions uncertain."""
    steps = family(planned, "probes").steps
    problem = typical.problem
    channels = (*problem.channels, *(Channel(step.position, step.direction) for step in steps))
    enlarged = problem.at(problem.speed, channels)
    assert len(Numbers.of(enlarged)) > 13
    exact = identifiability(enlarged, typical.x(), NOISE, "amplitude")
    assert steps[-1].crlb == pytest.approx(exact.crlb, rel=1e-5)  # another reduction of the same rotor


def test_two_probes_of_one_plane_share_its_position(typical):
    """x and y at 0.5 m, each chosen after the other: their common position is one number."""
    problem = typical.problem
    x, y = Channel(0.5, "x"), Channel(0.5, "y")
    one = problem.at(problem.speed, (*problem.channels, x))
    both = problem.at(problem.speed, (*problem.channels, x, y))
    names = [set(Numbers.of(each).names) - set(Numbers.of(problem).names) for each in (one, both)]
    assert len(names[0]) == 3 and len(names[1]) == 5  # a position; gain and direction of each

    only = PlanningOptions(target="u", add=0, trial_phases=[], numbers=0, sensors=27)
    steps = family(planning_study(point_of(typical), only), "probes").steps
    channels = (*problem.channels, *(Channel(step.position, step.direction) for step in steps))
    every = identifiability(problem.at(problem.speed, channels), typical.x(), NOISE, "amplitude").crlb
    assert len(steps) == 26 and steps[-1].crlb == pytest.approx(every, rel=1e-5)


def test_a_fit_of_measured_data_is_where_a_plan_starts(typical):
    """Numbers as the joint fit found them, not as stated; the model that knows their tolerances is not rejected."""
    truth = typical.x()
    joint = typical.problem.joint
    values = joint_values(typical.problem, joint, truth, {"steel_youngs_modulus": 206e9})
    rng = np.random.default_rng(3)
    response = joint.response(values[None])[0]
    part = rng.standard_normal((*response.shape, 2)) @ [1, 1j] / np.sqrt(2)
    noise = Noise(0.02, 1e-8)
    data = ksmea.Measurement(
        typical.problem.speed, typical.problem.channels, response + part * noise.sd(np.abs(response)), noise, "drawn"
    )
    point = DesignPoint.of_measurement(Case(typical.problem, data), np.random.default_rng(0))
    assert set(point.numbers) == set(Numbers.of(typical.problem).names)
    assert point.numbers["steel_youngs_modulus"] > 202e9
    assert not point.lack_of_fit.rejected
    assert point.x[:2] == pytest.approx(truth[:2], rel=0.05)
    record = planning_study(point, PlanningOptions(target="kxx", add=0, sensors=0, trial_phases=[]))
    assert record.crlb == pytest.approx(identifiability_of(point).crlb, rel=1e-6)


# -- what is said and drawn --


def test_texts_and_tables_have_the_numbers(typical):
    record = identifiability_study(point_of(typical), IdentifiabilityOptions(variations=["numbers", "kind"]))
    said = identifiability_text.text(record)
    assert "these intervals allow for 13 numbers that are known to a tolerance:" in said
    assert "by noise; measure the density of steel better" in said
    rows = identifiability_text.frame(record).query("variation == 'numbers'")
    assert len(rows) == 14 * 5 and list(rows["value"])[-1] == "all numbers"
    # the table below the text leaves out numbers that matter to nobody, and counts them
    unseen = {entry.value for entry in record.least_variations}
    assert unseen and not any(f"{words}  " in said for words in unseen)
    assert f"{len(unseen)} numbers more would narrow no interval by 1 % if exact" in said
    assert IdentifiabilityRecord.from_data(json.loads(json.dumps(record.to_data(), allow_nan=False))) == record
    panel = identifiability_chart(record).panels[-1]
    assert list(panel.y.ticks.values()) == [
        entry.value for entry in record.variations if entry.variation == "numbers" and entry.value not in unseen
    ]


def test_a_plan_names_the_numbers_to_measure(typical, rotor_with):
    options = PlanningOptions(target="kxx", n_candidate=20, add=1, sensors=1, trial_phases=[0.0])
    record = planning_study(point_of(typical), options)
    [line] = [each for each in planning_text.text(record).splitlines() if each.startswith("- measure")]
    assert line.startswith("- measure the density of steel, the ") and "until they are as good as exact" in line
    assert "repeating the present run instead: −" in line
    table = planning_text.frame(record)
    assert list(table.query("family == 'numbers' and parameter == 'kxx'")["number"]) == [
        step.number for step in family(record, "numbers").steps
    ]
    assert PlanningRecord.from_data(json.loads(json.dumps(record.to_data(), allow_nan=False))) == record
    panel = planning_chart({"": record}).panels[-1]
    assert len(panel.y.ticks) == 12 and panel.y.ticks[0.0] == "density of steel"
    falls = np.array(family(record, "numbers").candidates.reduction_pct)
    drawn = panel.elements[0]
    assert list(drawn.y) == list(range(12)) and list(drawn.x) == sorted(falls, reverse=True)[:12] and len(falls) == 13

    exact = planning_study(point_of(rotor_with("")), options)
    assert [each.family for each in exact.families] == ["speeds", "probes", "trial run"]
    assert "number" not in planning_text.frame(exact) and not any("number" in remark for remark in exact.remarks)
    none = planning_study(point_of(typical), dataclasses.replace(options, numbers=0))
    assert "no numbers are considered: study.numbers is 0" in none.remarks


def test_numbers_alone_are_enough_to_plan(typical, rotor_with):
    only = PlanningOptions(add=0, sensors=0, trial_phases=[])
    assert [each.family for each in planning_study(point_of(typical), only).families] == ["numbers"]
    with pytest.raises(ksmea.SettingError, match="expected something to add"):
        planning_study(point_of(rotor_with("")), only)


def test_an_unknown_with_a_prior_is_no_number_to_measure(rotor_with):
    """Limits make it an unknown; its prior is present data of a plan, and of `identifiability`."""
    rotor = rotor_with("", "young_modulus: 200", "young_modulus: {value: 200, sd: 4, lower: 180, upper: 220}")
    x = rotor.x({rotor.problem.parameters.names[-1]: 200.0})
    point = DesignPoint(rotor.problem, x, NOISE, "amplitude")
    record = planning_study(point, PlanningOptions(n_candidate=20, add=1))
    assert not len(Numbers.of(rotor.problem)) and "numbers" not in [each.family for each in record.families]
    assert 0 < record.crlb[-1] <= 4e9
    assert record.crlb == pytest.approx(identifiability_of(point).crlb, rel=1e-6)


def test_numbers_of_a_fit_are_told_apart_from_unknowns_with_a_prior(rotor_with):
    """The prior of an unknown stands first among priors; values and standard deviations of numbers are those of the inverse."""
    coupled = "{position: 0.0, kxy: {value: 1, sd: 0.1, lower: 0.5, upper: 2}}"
    rotor = rotor_with("tolerances: typical", "{position: 0.0}", coupled)
    problem, joint = rotor.problem, rotor.problem.joint
    [first] = set(problem.parameters.names) - {"kxx", "kyy", "cxx", "cyy", "u"}
    assert joint.parameters.names.index(first) == joint.parameters.with_prior[0]
    x = joint_values(problem, joint, rotor.x({first: 1.0}))
    data = ksmea.Measurement(problem.speed, problem.channels, joint.response(x[None])[0], Noise(0.02, 1e-8), "made")
    likelihood = likelihood_of(Case(problem, data).by(joint))
    fit = Fit(likelihood, likelihood.at(likelihood.start(joint.parameters.to_cube(x))))
    sd = np.sqrt(np.diag(np.linalg.inv(fit.point.information))) * joint.parameters.width
    for record in input_records(fit):
        place = joint.parameters.names.index(record.name)
        prior = joint.parameters.items[place].prior
        assert (record.stated, record.stated_sd) == (prior.value, prior.sd)
        assert record.value == pytest.approx(prior.value) and record.sd == pytest.approx(sd[place], rel=1e-5)
