"""A value and its ends are told to the decimals that they have in common."""

import pytest

from ksmea.show.text import rounded_alike


@pytest.mark.parametrize(
    "values, expected",
    [
        ((50.0, 12.34, 87.66), ["50", "12", "88"]),  # half the width: 38
        ((50.0, 12.34, None), ["50", "12", "–"]),  # half the distance: 19
        ((50.0, None, 87.66), ["50", "–", "88"]),
        ((50.0, 49.876, None), ["50.00", "49.88", "–"]),  # 0.062 would be a decimal more than four digits have
        ((12.34, 50.0, None), ["12", "50", "–"]),
        ((0.50662, 0.47401, float("nan")), ["0.507", "0.474", "–"]),
        ((50.0, None, None), ["50.00", "–", "–"]),  # alone
        ((12.346,), ["12.35"]),
        ((1234567.0, 1.0, None), ["1230000", "1", "–"]),  # to 10 000 the end would be 0: each by itself
        ((1234567.0, 100000.0, None), ["1230000", "100000", "–"]),  # to 10 000 both, which leaves the end two digits
    ],
)
def test_one_end_is_told_as_both_are_but_to_four_digits_at_most(values, expected):
    assert rounded_alike(*values) == expected
