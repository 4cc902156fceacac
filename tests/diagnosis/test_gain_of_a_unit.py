"""A plane or a probe in another unit than the others is a channel gain, with its size and the unit that has this factor."""

import dataclasses

import numpy as np
import pytest

from ksmea.problem.case import Case
from ksmea.studies.diagnose import DiagnosisOptions, diagnosis
from ksmea.studies.library import library
from tiers import mostly_slow
from tolerant_pump import measured, pump, true_values

RIVALS = ("probe_position", "channel_gain", "added_mass", "mass", "probe_rotation")
QUICK = DiagnosisOptions(locate=False, average=False, split=False, screening=512, starts=4)


@pytest.mark.parametrize(
    ("factor", "columns", "location", "unit"),
    mostly_slow(
        [
            (
                2.0,
                [2, 3],
                "x and y at 0.51 m",
                "0-peak",
            ),  # or half of that at the other plane, with twice the unbalance
            (25.4, [2, 3], "x and y at 0.51 m", "converted from mil though they were in µm"),
            (1 / 25.4, [0], "x at 0.16 m", "in mil where µm are expected"),
        ],
        but=[25.4],
    ),
)
def test_a_unit_is_found(tmp_path, factor, columns, location, unit):
    settings = pump(tmp_path)
    problem, data = settings.build(), measured(settings, true_values(settings), np.random.default_rng(1), relative=0.03)
    values = data.values.copy()
    values[:, columns] *= factor
    data = dataclasses.replace(data, values=values)
    chosen, _ = library(RIVALS, [], data, problem)
    found = diagnosis(Case.of(problem, data), chosen, np.random.default_rng(0), options=QUICK)
    assert found.named == ("channel_gain",) and location in found.locations
    size = next(each for each in found.ranking if each.location == location).parameters[0]
    # noise of 3 % on 23 speeds: 0.6 % of the factor
    assert 1 + size.value / 100 == pytest.approx(factor, rel=0.03)
    assert any(unit in remark for remark in found.remarks)
