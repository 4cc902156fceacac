"""Choice of additions: against all possible choices on the real rotor, textbook designs of a straight line, and bounds that
data never make worse."""

from itertools import combinations

import numpy as np
import pytest

import ksmea
from ksmea.inference.cramer_rao import identifiability
from ksmea.inference.optimal_design import Criterion, choose, crlb, data_rows, information, mean_axis_reduction_pct
from ksmea.measurement.channel import Channel
from ksmea.measurement.noise import Noise
from ksmea.units import GRAM_MILLIMETRE
from problems.rk4_two_disk import RK4TwoDisk
from problems.three_disk import ThreeDisk

NOISE = Noise(0.1, 1e-8)
NAMES = ("kxx", "kyy", "cxx", "cyy", "u")


def truth(settings):
    values = settings.reference()
    return np.array([values[name] for name in settings.build().parameters.names])


def rows_of(problem, settings=None, kind="amplitude", noise_known=True):
    return data_rows(problem, truth(settings or ThreeDisk()), NOISE, kind, noise_known=noise_known)


def flat(rows):
    return rows.reshape(-1, rows.shape[-1])


def by_speed(rows):
    """Information (n_speed, k, k) of all data of each speed."""
    return np.stack([information(flat(rows[:, place])) for place in range(rows.shape[1])])


def line(x):
    """Information (n, 2, 2) of measurements of a + b x with a standard deviation of 1e-3: the prior is next to nothing."""
    rows = 1e3 * np.stack([np.ones_like(x), x], axis=-1)
    return rows[:, :, None] * rows[:, None, :]


@pytest.fixture(scope="module")
def rotor():
    """The three-disk rotor measured at 14 speeds, and 12 speeds to add: informations and the problem."""
    problem = ThreeDisk(n_speed=14).build()
    present = information(flat(rows_of(problem)))
    candidates = by_speed(rows_of(problem.at(np.linspace(120.0, 2200.0, 12), problem.channels)))
    return present, candidates


@pytest.mark.parametrize("n_added", [1, 2, 3, 4])
@pytest.mark.parametrize("targets", [(0, 1, 2, 3, 4), (0,), (2,), (3,), (0, 1), (2, 3)], ids=str)
def test_no_other_set_of_speeds_tells_more(rotor, targets, n_added):
    """Greedy choice and exchange, against all up to 495 sets."""
    present, candidates = rotor
    criterion = Criterion(targets)
    every = [criterion.value(present + candidates[list(places)].sum(0)) for places in combinations(range(12), n_added)]
    chosen = choose(present, candidates, n_added, criterion)
    assert len(set(chosen)) == n_added
    # exchanges stop where a member gains less than 1e-6
    assert criterion.value(present + candidates[chosen].sum(0)) == pytest.approx(max(every), abs=1e-5)


def test_exchange_mends_what_greed_chose_wrong():
    """Present data telling hardly anything, the best single measurement of (a, b) is the longest, (2.2, 2.2); but the
    best pair is (0, 3) and (3, 0): its determinant is 81, with (2.2, 2.2) it is 43.56."""
    directions = 1e3 * np.array([[2.2, 2.2], [0.0, 3.0], [3.0, 0.0]])
    candidates = directions[:, :, None] * directions[:, None, :]
    both = Criterion((0, 1))
    assert choose(np.zeros((2, 2)), candidates, 1, both) == [0]
    assert sorted(choose(np.zeros((2, 2)), candidates, 2, both)) == [1, 2]


def test_the_first_chosen_tells_most_alone(rotor):
    present, candidates = rotor
    criterion = Criterion((3,))
    chosen = choose(present, candidates, 4, criterion)
    alone = criterion.value(present + candidates[chosen])
    assert np.argmax(alone) == 0


def test_a_straight_line_is_known_best_from_its_ends():
    """D-optimal: half of the points at each end."""
    x = np.linspace(-1, 1, 21)
    chosen = choose(np.zeros((2, 2)), line(x), 6, Criterion((0, 1)), repeats=6)
    assert sorted(x[chosen]) == [-1, -1, -1, 1, 1, 1]


def test_a_slope_is_known_best_from_both_ends():
    """Var b = 1 / Σ (x − x̄)²: half of the points at each end, also of an interval that does not contain 0."""
    x = np.linspace(1, 2, 11)
    chosen = choose(np.zeros((2, 2)), line(x), 4, Criterion((1,)), repeats=4)
    assert sorted(x[chosen]) == [1, 1, 2, 2]


def test_an_intercept_is_known_best_where_x_is_0():
    """Var a is at least 1/n; it is 1/n where the mean of x is 0, and present data that tell the slope need no more."""
    x = np.linspace(-1, 1, 21)
    present = np.diag([0.0, 1e6])  # the slope alone
    chosen = choose(present, line(x), 4, Criterion((0,)), repeats=4)
    total = present + line(x)[chosen].sum(0)
    assert np.mean(x[chosen]) == pytest.approx(0, abs=1e-12)
    assert np.linalg.inv(total)[0, 0] == pytest.approx(1e-6 / 4, rel=1e-12)


def test_an_intercept_beyond_the_points_is_extrapolated_as_elfving_says():
    """c-optimal for a + b x at x = 0, from x in [1, 2]: weights |l| / Σ |l| of the Lagrange coefficients 2 and −1 of the
    ends (Elfving's theorem), so that of 6 points 4 lie at 1 and 2 at 2."""
    x = np.linspace(1, 2, 11)
    chosen = choose(np.zeros((2, 2)), line(x), 6, Criterion((0,)), repeats=6)
    assert sorted(x[chosen]) == [1, 1, 1, 1, 2, 2]


def test_the_reduction_by_a_repeated_measurement_is_that_of_the_root_of_2():
    present = line(np.array([-1.0, 1.0])).sum(0)
    for targets in [(0,), (0, 1)]:
        # but for the prior's 0.12 on an information of 2e6
        assert Criterion(targets).reduction_pct(present, 2 * present) == pytest.approx(
            100 * (1 - np.sqrt(0.5)), rel=1e-6
        )


def test_a_single_unknown_has_the_variance_of_the_inverse(rotor):
    """A quotient of determinants is what inverting gives, the prior of ten times the range's 1/√12 counted."""
    present, _ = rotor
    inverse = np.linalg.inv(present + 12 / 10**2 * np.eye(5))
    for place in range(5):
        # information about k and c differs by 1e6: that leaves 1e-10 of 16 digits
        assert np.exp(-Criterion((place,)).value(present)) == pytest.approx(inverse[place, place], rel=1e-9)


def test_the_prior_moves_crlbs_inside_the_range_by_half_a_per_cent_at_most():
    for share in (1.0, 0.1):  # of the standard deviation 1/√12 of a value drawn evenly
        variance = share**2 / 12
        with_prior = np.exp(-Criterion((0,)).value(np.diag([1 / variance, 1.0])))
        assert 0.99 * variance <= with_prior < variance  # 1/(1 + share²/100): 1 % of a variance is half of a bound


def test_axes_of_the_ellipsoid_shrink_with_the_volume():
    rows = np.array([[3.0, 1.0], [0.0, 2.0]])
    more = np.vstack([rows, [1.0, 5.0]])
    volumes = [np.sqrt(np.linalg.det(np.linalg.inv(part.T @ part))) for part in (rows, more)]
    assert mean_axis_reduction_pct(rows, more, 2) == pytest.approx(100 * (1 - np.sqrt(volumes[1] / volumes[0])))
    # the half axis that neither knows is left out: of the other, four times the data leave half
    single = np.array([[3.0, 0.0]])
    assert mean_axis_reduction_pct(single, np.vstack(4 * [single]), 2) == pytest.approx(50)


@pytest.mark.parametrize("kind", ["amplitude", "complex"])
@pytest.mark.parametrize("noise_known", [True, False])
def test_the_crlb_is_that_of_identifiability(kind, noise_known):
    problem = ThreeDisk(n_speed=14).build()
    found = crlb(flat(rows_of(problem, kind=kind, noise_known=noise_known)), 5) * problem.parameters.width
    expected = identifiability(problem, truth(ThreeDisk()), NOISE, kind, noise_known=noise_known).crlb
    assert found == pytest.approx(expected, rel=1e-6)  # the same by columns of another scale


@pytest.mark.parametrize("noise_known", [True, False])
def test_what_is_added_never_worsens_a_crlb(noise_known):
    problem = ThreeDisk(n_speed=14).build()
    present = flat(rows_of(problem, noise_known=noise_known))
    before = crlb(present, 5)
    trial = problem.with_unbalance(1.0, 200 * GRAM_MILLIMETRE, 0.5)
    probes = problem.at(problem.speed, [Channel(float(site), "x") for site in problem.sites])
    speeds = problem.at(np.linspace(100.0, 2000.0, 20), problem.channels)
    for added in (trial, probes, speeds):
        after = crlb(np.concatenate([present, flat(rows_of(added, noise_known=noise_known))]), 5)
        assert np.all(after <= before * (1 + 1e-9))  # rounding
        assert np.all(after < before)


def test_a_trial_run_tells_what_a_rotor_with_that_unbalance_tells():
    """By the second route: derivatives of the dense solution of the rotor with both unbalances, by differences."""
    problem = ThreeDisk(n_speed=7).build().with_unbalance(1.0, 150 * GRAM_MILLIMETRE, 1.0)
    x, width = truth(ThreeDisk()), problem.parameters.width
    step = 1e-4 * x
    shifts = [problem.dense_response(x + sign * np.diag(step)) for sign in (-2, -1, 1, 2)]
    slope = np.moveaxis((shifts[0] - 8 * shifts[1] + 8 * shifts[2] - shifts[3]) / 12, 0, -1) / step * width
    mean = problem.dense_response(x[None])[0]
    size = np.abs(mean)
    size_slope = (mean.conj()[..., None] * slope).real / size[..., None]
    variance = (0.1 * size) ** 2 + 1e-16
    variance_slope = 2 * 0.01 * size[..., None] * size_slope
    expected = np.einsum("sci,scj,sc->ij", size_slope, size_slope, 1 / variance)
    expected += np.einsum("sci,scj,sc->ij", variance_slope, variance_slope, 1 / (2 * variance**2))
    found = information(flat(rows_of(problem)))
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    # fourth-order differences of a dense solution that is good to 1e-9 at these steps of 1e-4
    assert found / scale == pytest.approx(expected / scale, abs=1e-4)


def test_amplitudes_tell_absolute_phases_with_a_trial_run_only():
    """Two unknown unbalances turned together leave all amplitudes as they are; with a third, known one they do not."""
    settings = RK4TwoDisk(n_speed=25)
    problem = settings.build()
    d, phases = len(problem.parameters), [5, 7]
    present = flat(rows_of(problem, settings))
    speeds = flat(rows_of(problem.at(np.linspace(80.0, 300.0, 50), problem.channels), settings))
    trial = flat(rows_of(problem.with_unbalance(0.4, 2 * GRAM_MILLIMETRE, 0.0), settings))
    assert np.all(np.isinf(crlb(present, d)[phases]))
    assert np.all(np.isinf(crlb(np.concatenate([present, speeds]), d)[phases]))
    assert np.all(np.isfinite(crlb(np.concatenate([present, trial]), d)))


def test_more_than_there_are_cannot_be_chosen():
    with pytest.raises(ValueError, match="at most 6"):
        choose(np.eye(2), line(np.array([-1.0, 0.0, 1.0])), 7, Criterion((0,)), repeats=2)


def test_a_trial_weight_that_cancels_the_unbalance_is_none_to_take():
    """200 g mm against the 200 g mm of the rotor leaves rounding, of which each value's relative noise would tell u to 1e-16."""
    rotor = ksmea.load_problem("three_disk")
    [plane] = [position for position, vector in rotor.problem.unbalance(rotor.x()).items() if vector]
    planned = ksmea.plan(rotor, relative=0.1, trial_unbalance=200.0, trial_sites=[plane], add=0, sensors=0)
    [family] = planned.record.families
    assert np.degrees(family.candidates.phase) == pytest.approx([0.0, 90.0, 270.0])
    assert all(1e-3 < width / before <= 1 for width, before in zip(family.steps[-1].crlb, planned.record.crlb))
