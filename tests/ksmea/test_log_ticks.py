"""Ticks of logarithmic axes, as they stand on figures."""

import pytest
from matplotlib.figure import Figure

from ksmea.show.charts.locators import plain_ticks


@pytest.mark.parametrize(
    ("low", "high", "shown"),
    [
        (1, 8, ["1", "2", "5"]),
        (0.3, 60, ["1", "10"]),
        (95, 105, ["96", "98", "100", "102", "104"]),
        (1e-9, 1, ["$10^{-8}$", "$10^{-6}$", "$10^{-4}$", "$10^{-2}$", "$10^{0}$"]),
    ],
)
def test_numbers_of_a_logarithmic_axis_are_plain_or_all_powers(low, high, shown):
    panel = Figure().subplots()
    panel.set_yscale("log")
    plain_ticks(panel.yaxis)
    panel.set_ylim(low, high)
    texts = [label.get_text() for label, at in zip(panel.get_yticklabels(), panel.get_yticks()) if low <= at <= high]
    assert texts == shown


def test_an_axis_to_both_sides_has_no_ticks_within_its_linear_part_but_0():
    panel = Figure().subplots()
    panel.set_yscale("symlog", linthresh=5e-5)
    plain_ticks(panel.yaxis)
    panel.set_ylim(-0.02, 0.02)
    assert [label.get_text() for label in panel.get_yticklabels()] == [
        "−0.01", "−0.001", "−0.0001", "0", "0.0001", "0.001", "0.01",
    ]  # fmt: skip
