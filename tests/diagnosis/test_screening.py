"""Where fits start: values of effects all over their limits, and clouds that close in on the best points."""

import numpy as np
import pytest

from ksmea.fits.starts import refined_by_clouds, scan_values, scanned, screened
from ksmea.numerics.screening import Screened
from ksmea.problem.case import Case
from tests.diagnosis.conftest import registered_effects


@pytest.mark.parametrize("zero", [[0.0], [1.0], [0.5], [0.375], [0.0, 0.5], [0.5, 0.5, 1.0]])
def test_scanned_values_are_inside_the_bounds_on_both_sides_of_zero_and_denser_near_it(zero):
    zero = np.array(zero)
    values = scan_values(zero, 16)
    assert values.shape == (16 * 2 ** (len(zero) - 1), len(zero))
    assert np.all((values > 0) & (values < 1))
    for column, place in zip(values.T, zero):
        for side, room in ((column[column > place], 1 - place), (column[column < place], place)):
            assert len(side) == (0 if room == 0 else len(values) // (2 if 0 < place < 1 else 1))
            if room:
                distances = abs(side - place) / room
                assert np.median(distances) < 0.4 and distances.max() > 0.8  # half of them in the nearer 0.35


def test_an_effect_of_one_unknown_is_scanned_evenly_in_the_bent_measure():
    """No gap: between neighbours a sixteenth of the range to the power of 1.5, as the docstring of the module says."""
    bent = np.sort(np.abs(scan_values(np.array([0.0]), 16)[:, 0]) ** (1 / 1.5))
    assert np.diff(bent) == pytest.approx(1 / 16)


def test_screened_points_are_ranked_and_aligned_with_the_data(rotor, hide):
    """Unbalance and phase origin act on all data alike: whatever they were, they come out as the data have them."""
    measurement, _, _ = hide(None, 0)
    middle = np.full(len(rotor.parameters), 0.5)
    u, origin = rotor.parameters.names.index("u"), rotor.parameters.names.index("phase_origin")
    others = np.tile(middle, (5, 1))
    others[:, u], others[:, origin] = np.linspace(0.2, 0.8, 5), np.linspace(0, 1, 5)
    found = screened(Case(rotor, measurement), np.vstack([others, np.full_like(middle, 0.3)]))
    assert np.all(np.diff(found.misfits) >= 0)
    same = found.points[np.isclose(found.points[:, 0], 0.5)]
    assert len(same) == 5 and np.ptp(same, axis=0) == pytest.approx(0, abs=1e-9)


def test_clouds_close_in_on_a_maximum_that_the_scan_only_came_near(rotor, hide):
    """A flexible pedestal whose resonance lies in the band: the misfit at the truth is that of the noise alone."""
    measurement, place, size = hide("flexible_pedestal", 3)
    extended = place.added_to(rotor)
    zero = np.zeros(4)
    grid = np.random.default_rng(0).uniform(size=(200, len(rotor.parameters)))
    found = scanned(Case(extended, measurement), grid, scan_values(zero, 16), 48)
    best_of_scan = min(
        screened(Case(extended, measurement), np.hstack([grid, np.tile(value, (200, 1))])).misfits[0]
        for value in scan_values(zero, 16)
    )
    truth = [rotor.parameters.to_cube(np.array([50e6, 70e6, 500.0, 700.0, 2e-4, 0.6])), size]
    truth[1] = extended.parameters.to_cube(np.concatenate([np.zeros(len(rotor.parameters)), size]))[-4:]
    at_truth = screened(Case(extended, measurement), np.concatenate(truth)[None]).misfits[0]
    assert found.misfits[0] < best_of_scan
    assert found.misfits[0] - at_truth < 0.5 * (best_of_scan - at_truth)


def test_costly_unknowns_take_few_values_in_clouds(rotor, hide, monkeypatch):
    """Each value of the modulus costs a reduction anew."""
    measurement, _, _ = hide("youngs_modulus", 3)
    extended = registered_effects()["youngs_modulus"].added_to(rotor)
    values = set()
    original = type(extended).response

    def counted(self, x):
        values.update(x[:, -1])
        return original(self, x)

    monkeypatch.setattr(type(extended), "response", counted)
    start = Screened(np.full((1, len(extended.parameters)), 0.5), np.array([9.0]))
    found = refined_by_clouds(Case(extended, measurement), start, 48)
    assert len(values) < 150 and len(values) < len(found.points) * 3
    assert found.misfits[0] < 9.0
