"""Values and intervals as records have them."""

import pytest

from ksmea.records.estimate import EstimateRecord


@pytest.mark.parametrize(
    ("unit", "interval", "true", "is_held"),
    [
        ("deg", (-160.2, -161.0, -159.0), 200.0, True),  # the same angle, one turn before
        ("deg", (179.8, 179.0, 180.6), -179.7, True),
        ("deg", (179.8, 179.0, 180.6), -178.0, False),
        ("deg", (-530.0, -540.0, -520.0), 190.0, True),
        ("MN/m", (-160.2, -161.0, -159.0), 200.0, False),
        ("MN/m", (50.0, 49.0, None), 400.0, True),
    ],
)
def test_an_interval_holds_a_value_and_that_of_an_angle_any_of_its_turns(unit, interval, true, is_held):
    assert EstimateRecord("a", unit, *interval, "profile", False).holds(true) is is_held
