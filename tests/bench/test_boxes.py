"""Boxes and intervals of pages show what their tables say."""

import numpy as np
import pytest

from bench.reports.identification.spread_chart import MARKS, MEDIAN_INTERVAL, drawn_ends, interval_elements
from ksmea.show.charts import interactive
from ksmea.show.charts.chart import Axis, Boxes, one_panel


def traces_of(*elements, scale="linear"):
    return interactive.plot(one_panel(elements, Axis(), Axis("", scale), "", ""))["data"]


def test_a_box_has_the_quartiles_of_the_table():
    values = [3.0, 1.0, 8.0, np.nan, 2.0, 5.0, 13.0]
    [box] = traces_of(Boxes([0.0], [values]))
    told = np.quantile([1, 2, 3, 5, 8, 13], [0.25, 0.5, 0.75])
    assert [box[name][0] for name in ("q1", "median", "q3")] == pytest.approx(told)
    assert box["lowerfence"] == [1.0] and box["upperfence"] == [13.0]


def interval(values, low, high, **more):
    return interval_elements(np.zeros(1), np.array([low]), np.array([high]), np.array(values), **more)


def test_an_interval_without_a_lower_end_points_left_also_where_all_values_lie_above_it():
    low, high = drawn_ends(np.array([np.nan]), np.array([0.9]), np.array([0.95, 1.0]))
    assert low < high == 0.9
    line, arrow = interval([0.95, 1.0], np.nan, 0.9)
    assert line.name == MEDIAN_INTERVAL and line.x[0] < line.x[1] == 0.9 and np.isnan(line.x[2])
    assert arrow.symbol == "triangle left" and list(arrow.x) == list(line.x[:1])
    assert "with an arrow where it is open" in MARKS[MEDIAN_INTERVAL]
    assert [trace["mode"] for trace in traces_of(line, arrow)] == ["lines", "markers"]


def test_an_open_end_stays_above_0_on_a_logarithmic_axis():
    line, _ = interval([0.01, 1.0], np.nan, 0.9, is_log=True)
    assert 0 < line.x[0] < 0.01


def test_a_value_of_0_is_not_drawn_on_a_logarithmic_axis(recwarn):
    """Ends beyond by a tenth of the decade that is left, and no warning of a division by 0."""
    low, high = drawn_ends(np.array([0.0, np.nan]), np.array([1.0, np.nan]), np.array([0.0, 0.1, 1.0]), is_log=True)
    assert (low, high) == (pytest.approx([10**-1.1] * 2), pytest.approx([1.0, 10**0.1]))
    assert not recwarn.list
