"""Joint fits: priors as data, what they do to values, intervals and tests, and where the uncertainty comes from."""

import dataclasses

import numpy as np
import pytest
import scipy

from ksmea.fits.fitting import Fit, fit_baseline
from ksmea.fits.joint_fit import joint_baseline, joint_maxima
from ksmea.fits.lack_of_fit import fit_quality
from ksmea.fits.search import Effort, Search
from ksmea.inference.cramer_rao import identifiability
from ksmea.inference.input_budget import critical_pull, input_budget
from ksmea.inference.intervals import estimate
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.measurement.campaign import Campaign, Run, Weight
from ksmea.measurement.measurement import Layout, Measurement
from ksmea.measurement.noise import Noise
from ksmea.numerics.differences import differenced
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.problem.held import HeldProblem
from ksmea.problem.parameters import Parameters, Prior
from ksmea.problem.problem import joint_values
from ksmea.studies.inputs import input_records, origins_of
from ksmea.testing.jeffcott import Jeffcott, JeffcottRotor
from measurements.synthetic import Synthetic
from problems.rotor_file import RotorFile
from tolerant_pump import UNCERTAIN, measured, pump, true_values

TRUTH = np.array(list(JeffcottRotor().reference().values()))


class JeffcottWithPriors(Jeffcott):
    """The closed form with priors on some unknowns, as if they were numbers of a drawing."""

    def __init__(self, priors):
        super().__init__()
        items = (
            dataclasses.replace(item, prior=priors[item.name], is_input=True) if item.name in priors else item
            for item in Jeffcott.parameters
        )
        object.__setattr__(self, "parameters", Parameters(tuple(items)))


def jeffcott_data(problem, rng, relative=0.02):
    response = problem.response(TRUTH[None])[0]
    parts = rng.standard_normal((2, *response.shape)) / np.sqrt(2)
    values = response + relative * np.abs(response) * (parts[0] + 1j * parts[1])
    return Measurement(problem.speed, problem.channels, values, noise=Noise(relative, 0.0), source="closed form")


def test_a_prior_is_a_datum():
    """The penalised deviance, its gradient and its information, by hand and by differences."""
    problem = JeffcottWithPriors({"cxx": Prior(1000.0, 50.0), "u": Prior(4e-4, 2e-5)})
    data = jeffcott_data(problem, np.random.default_rng(0))
    with_priors, plain = likelihood_of(Case(problem, data)), likelihood_of(Case(Jeffcott(), data))
    x = TRUTH * np.array([1.01, 0.99, 1.02, 1.0, 1.03])
    u = problem.parameters.to_cube(x)
    penalty = ((x[2] - 1000) / 50) ** 2 + ((x[4] - 4e-4) / 2e-5) ** 2
    assert with_priors.deviance(u) == pytest.approx(plain.deviance(u) + penalty, rel=1e-12)
    point, bare = with_priors.at(u), plain.at(u)
    assert point.deviance == pytest.approx(with_priors.deviance(u), rel=1e-12)
    [gradient] = differenced(lambda at: np.array([[with_priors.deviance(each)] for each in at]), u, 1e-6, u - 1, u + 1)[
        1
    ]
    assert point.gradient == pytest.approx(gradient, rel=1e-5)
    information = np.zeros((5, 5))
    information[2, 2], information[4, 4] = (problem.parameters.width[[2, 4]] / [50, 2e-5]) ** 2
    assert np.allclose(point.information, bare.information + information, rtol=1e-12)
    assert (with_priors.n_free, plain.n_free) == (3, 5)


def test_a_tight_prior_holds_its_number_and_a_wide_one_says_nothing():
    data = jeffcott_data(Jeffcott(), np.random.default_rng(1))
    start = Jeffcott.parameters.to_cube(TRUTH)
    free = maximise(likelihood_of(Case(Jeffcott(), data)), start)
    found = {}
    for sd in (1e-3, 1e9):
        case = Case(JeffcottWithPriors({"cxx": Prior(950.0, sd)}), data)
        found[sd] = Fit(likelihood_of(case), maximise(likelihood_of(case), start))
    assert found[1e9].x == pytest.approx(Jeffcott.parameters.to_si(free.theta), rel=1e-6)
    held = HeldProblem(Jeffcott(), np.array([0, 1, 3, 4]), np.array([0.0, 0.0, 950.0, 0.0, 0.0]))
    others = maximise(likelihood_of(Case(held, data)), np.delete(start, 2))
    assert found[1e-3].x[2] == pytest.approx(950.0, abs=0.01)
    assert np.delete(found[1e-3].x, 2) == pytest.approx(held.parameters.to_si(others.theta), rel=1e-5)


def test_variances_add_up_and_match_those_of_draws():
    """Of the estimates over draws of noise and of the number from its prior; by the budget at one fit."""
    problem = JeffcottWithPriors({"u": Prior(TRUTH[4], 0.02 * TRUTH[4])})
    rng = np.random.default_rng(2)
    errors = []
    for _ in range(400):
        off = TRUTH.copy()
        off[4] *= 1 + 0.02 * rng.standard_normal()
        response = problem.response(off[None])[0]
        parts = rng.standard_normal((2, *response.shape)) / np.sqrt(2)
        values = response + 0.02 * np.abs(response) * (parts[0] + 1j * parts[1])
        data = Measurement(problem.speed, problem.channels, values, noise=Noise(0.02, 0.0), source="closed form")
        likelihood = likelihood_of(Case(problem, data))
        fit = Fit(likelihood, maximise(likelihood, problem.parameters.to_cube(off)))
        errors.append(fit.x - off)
    budget = input_budget(fit.point, problem.parameters)
    covariance = np.linalg.inv(fit.point.information)
    assert budget.by_noise**2 + budget.by_inputs**2 == pytest.approx(np.diag(covariance), rel=1e-9)
    sd = np.sqrt(np.diag(covariance)) * problem.parameters.width
    assert np.std(errors, axis=0) == pytest.approx(sd, rel=0.12)  # √(1/800) = 3.5 % each, five of them
    assert critical_pull(1) == pytest.approx(scipy.stats.norm.isf(0.005))


def test_priors_are_projected_out_as_data(tmp_path):
    """p of the lack-of-fit test is even over (0, 1) for a right model with numbers off within their tolerance."""
    settings = pump(
        tmp_path, modulus="{value: 205, sd: 2 %}", mass="{value: 9.0, sd: 1 %}", probe="{value: 0.16, sd: 0.004}"
    )
    problem, rng, p = settings.build(), np.random.default_rng(3), []
    for _ in range(24):
        names = [item.name for item in problem.joint.parameters if item.is_input]
        x = true_values(settings, **{name: rng.standard_normal() for name in names})
        case = Case.of(problem.joint, measured(settings, x, rng))
        likelihood = likelihood_of(case)
        fit = Fit(likelihood, maximise(likelihood, problem.joint.parameters.to_cube(x)))
        p.append(fit_quality(fit, rng, n_simulated=400).p)
    assert scipy.stats.kstest(p, "uniform").pvalue > 1e-3


def test_the_joint_fit_mends_what_wrong_numbers_do(tmp_path):
    """Three numbers off by one or two standard deviations: intervals with numbers as stated miss, joint ones hold."""
    settings = pump(tmp_path, **UNCERTAIN)
    problem = settings.build()
    x = true_values(settings, steel_youngs_modulus=1.5, probe_position_at_0_16_m=-2, disk_2_mass=1)
    data = measured(settings, x, np.random.default_rng(4), relative=0.02)
    truth = x[: len(problem.parameters)]
    as_stated = likelihood_of(Case.of(problem, data))
    nominal = maximise(as_stated, problem.parameters.to_cube(truth))
    joint = likelihood_of(Case.of(problem.joint, data))
    start = problem.joint.parameters.to_cube(
        joint_values(problem, problem.joint, problem.parameters.to_si(nominal.theta))
    )
    best = joint_maxima(joint, [start])[0]

    def off(likelihood, point):
        found = estimate(likelihood, point, check=False)
        sd = np.array([each.high - each.low for each in found.intervals])[:4] / 3.92
        return np.abs(found.x[:4] - truth) / sd, sd

    (off_stated, sd_stated), (off_joint, sd_joint) = off(as_stated, nominal), off(joint, best)
    assert off_stated.max() > 4 and off_joint.max() < 3
    assert np.all(sd_joint > sd_stated)
    assert best.deviance < joint.deviance(problem.joint.parameters.to_cube(x))  # no lower maximum was taken
    fit = Fit(joint, best)
    records = {each.name: each for each in input_records(fit)}
    assert records["steel_youngs_modulus"].is_seen and not any(each.is_contradicted for each in records.values())
    origins = origins_of(fit, range(4))
    assert all(0 < origin.of_inputs < 1 and sum(share for _, share in origin.shares) <= 1 for origin in origins)


@pytest.mark.parametrize(("off", "first_is_best"), [(1.0, True), (-0.5, False)])
def test_a_joint_fit_starts_again_where_its_first_maximum_misses_the_data(off, first_is_best):
    """Sharp resonances with Young's modulus off by so many standard deviations: n squares of the noise remain, n ± √(2n)."""
    settings = RotorFile("docs/examples/rotor.yaml", tolerances="typical")
    problem, x = settings.build(), true_values(settings, steel_youngs_modulus=off)
    data = measured(settings, x, np.random.default_rng(4))
    nominal = maximise(likelihood_of(Case.of(problem, data)), problem.parameters.to_cube(x[: len(problem.parameters)]))
    stated = joint_values(problem, problem.joint, problem.parameters.to_si(nominal.theta))
    start = problem.joint.parameters.to_cube(stated)
    first, whole = (likelihood_of(Case.of(problem.joint, data)) for _ in range(2))
    alone, [best, *_] = maximise(first, first.start(start)), joint_maxima(whole, [start])
    n = whole.n_residual
    assert abs(best.deviance - n) < 3 * np.sqrt(2 * n) and best.deviance < alone.deviance + 1e-3
    assert (alone.deviance < n + 3 * np.sqrt(2 * n)) == first_is_best
    assert (whole.model.jacobians < 2 * first.model.jacobians) == first_is_best


def test_a_number_that_is_wrong_by_far_is_contradicted(tmp_path):
    settings = pump(tmp_path, probe="{value: 0.16, sd: 0.002}", modulus="{value: 205, sd: 1 %}")
    problem = settings.build()
    x = true_values(settings, probe_position_at_0_16_m=20)
    likelihood = likelihood_of(Case.of(problem.joint, measured(settings, x, np.random.default_rng(5))))
    best = joint_maxima(likelihood, [problem.joint.parameters.to_cube(true_values(settings))])[0]
    [worst] = [each for each in input_records(Fit(likelihood, best)) if each.is_contradicted]
    assert worst.name == "probe_position_at_0_16_m" and worst.pull > critical_pull(2)


def test_bounds_count_what_numbers_take(tmp_path):
    """The Cramér–Rao bound of an unknown beside numbers with priors is that of data whose noise has their part: Σ + G S Gᵀ."""
    settings = pump(tmp_path, modulus="{value: 205, sd: 2 %}", density="{value: 7850, sd: 80}")
    problem, x = settings.build(), true_values(settings)
    noise = Noise(0.0, 1e-7)
    found = identifiability(problem, x[:4], noise, "complex").crlb
    _, slope = problem.joint.linearised(x)
    rows = np.concatenate([slope.real, slope.imag]).reshape(-1, len(x))
    sd = np.array([item.prior.sd for item in problem.joint.parameters.items[4:]])
    others = rows[:, 4:] * sd
    covariance = 0.5e-14 * np.eye(len(rows)) + others @ others.T
    scale = x[:4]
    information = (rows[:, :4] * scale).T @ np.linalg.solve(covariance, rows[:, :4] * scale)
    assert found == pytest.approx(scale * np.sqrt(np.diag(np.linalg.inv(information))), rel=1e-6)
    exact = identifiability(pump(tmp_path).build(), x[:4], noise, "complex").crlb
    assert np.all(found > exact)


def test_screened_points_have_the_numbers_as_stated(tmp_path):
    settings = pump(tmp_path, modulus="{value: 205, sd: 1 %}")
    problem = settings.build()
    data = measured(settings, true_values(settings), np.random.default_rng(6))
    fits = fit_baseline(Case.of(problem, data), Search(np.random.default_rng(0), Effort(screening=256, starts=3)))
    joint = joint_baseline(fits)
    assert np.allclose(joint.screened.points[:, :4], fits.screened.points, rtol=0, atol=1e-12)  # by way of SI
    assert np.allclose(joint.screened.points[:, 4], 0.5)
    assert joint.best.deviance < fits.best.deviance + 1e-6
    exact = joint_baseline(joint)
    assert exact is joint


def test_runs_of_a_campaign_share_their_numbers(tmp_path):
    """Each number once, as it is in every run; a trial weight beside."""
    settings = pump(tmp_path, modulus="{value: 205, sd: 2 %}", probe="{value: 0.16, sd: 0.004}")
    problem = settings.build()
    runs = (Run("bare", 23, ()), Run("trial", 23, (Weight(0.85, 3e-5, 0.4),)))
    layout = Layout(np.tile(problem.speed, 2), problem.channels, "complex", "made", True, campaign=Campaign(runs))
    whole = aligned(problem, layout)
    assert whole.joint.parameters.names == problem.joint.parameters.names
    x = true_values(settings, steel_youngs_modulus=1, probe_position_at_0_16_m=-1)
    response, slope = whole.joint.linearised(x)
    alone = problem.joint
    weighted = alone.with_unbalance(0.85, 3e-5, 0.4)
    expected = np.concatenate([alone.response(x[None])[0], weighted.response(x[None])[0]])
    assert np.abs(response - expected).max() < 1e-10 * np.abs(expected).max()
    assert np.allclose(slope[:23], alone.linearised(x)[1], rtol=1e-9, atol=1e-9 * np.abs(slope).max())
    assert whole.as_stated.parameters.names == problem.parameters.names == whole.parameters.names


def test_what_is_drawn_lies_in_the_data_and_not_in_the_model(tmp_path):
    """One seed with numbers as stated and drawn: other data by about the tolerances' influence."""
    settings = pump(tmp_path, **UNCERTAIN)
    reference = settings.reference()
    as_stated, drawn = (
        Synthetic(kind="complex", numbers=numbers).response(settings, reference, np.random.default_rng(1))
        for numbers in ("stated", "drawn")
    )
    x = np.array([reference[name] for name in settings.build().parameters.names])
    assert np.array_equal(as_stated, settings.build().response(x[None])[0])
    change = np.abs(drawn - as_stated).max() / np.abs(as_stated).max()
    assert 0.01 < change < 1
    again = Synthetic(kind="complex", numbers="drawn").response(settings, reference, np.random.default_rng(1))
    assert np.array_equal(drawn, again)
