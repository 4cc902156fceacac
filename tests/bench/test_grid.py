"""Which lines an experiment's grid has, and which points they stand for."""

import pytest

from bench.command_line.grid import grid_blocks, grid_points, labelled
from ksmea.errors import SettingError


def test_a_block_is_a_product_whose_last_axis_varies_first():
    assert grid_points([{"a": [1, 2], "b": ["x", "y"]}], {}, set()) == [
        {"a": 1, "b": "x"},
        {"a": 1, "b": "y"},
        {"a": 2, "b": "x"},
        {"a": 2, "b": "y"},
    ]


def test_blocks_are_united_and_need_not_have_the_same_axes():
    grid = [{"method": "direct", "optimizer": ["de", "ga"]}, {"method": "ksmea", "samples": [40, 70]}]
    assert grid_points(grid, {}, set()) == [
        {"method": "direct", "optimizer": "de"},
        {"method": "direct", "optimizer": "ga"},
        {"method": "ksmea", "samples": 40},
        {"method": "ksmea", "samples": 70},
    ]


def test_a_value_on_the_command_line_removes_the_axis():
    grid = [{"samples": [40, 70], "optimizer": ["de", "pso"]}]
    assert grid_points(grid, {}, {"samples"}) == [{"optimizer": "de"}, {"optimizer": "pso"}]
    assert grid_points(grid, {}, {"samples", "optimizer", "seed"}) == [{}]


def test_a_list_on_the_command_line_replaces_the_axis_where_it_stands():
    grid = [{"samples": [40, 70], "optimizer": ["de"]}]
    points = grid_points(grid, {"samples": (25, 30, 35)}, set())
    assert points == [{"samples": n, "optimizer": "de"} for n in (25, 30, 35)]


def test_a_list_on_the_command_line_adds_an_axis_to_every_block():
    points = grid_points([{"method": "direct"}, {"method": "ksmea"}], {"seed": (1, 2)}, set())
    assert points == [{"method": method, "seed": seed} for method in ("direct", "ksmea") for seed in (1, 2)]
    assert grid_points([], {"seed": (1, 2)}, set()) == [{"seed": 1}, {"seed": 2}]


def test_points_that_blocks_share_come_once():
    grid = [{"samples": [40, 70]}, {"samples": [70, 100]}, {"samples": 40}]
    assert grid_points(grid, {}, set()) == [{"samples": 40}, {"samples": 70}, {"samples": 100}]
    assert grid_points([{"a": [1], "samples": [40]}, {"a": [1], "samples": [70]}], {}, {"samples"}) == [{"a": 1}]
    assert grid_points([], {"seed": (1, 1)}, set()) == [{"seed": 1}]


def test_no_grid_is_one_point():
    assert grid_points([], {}, {"samples"}) == [{}]


LINES = [{"label": "LM", "optimizer": "lm"}, {"label": "DE", "optimizer": "de", "seed": 5}]


def test_every_line_added_ones_too_is_crossed_with_every_block_and_says_more_than_it():
    blocks = grid_blocks(LINES, [{"label": "Mine"}], [{"seed": [1, 2]}, {"problem": "rk4"}])
    assert blocks == [
        {"label": "LM", "optimizer": "lm", "seed": [1, 2]},
        {"label": "LM", "optimizer": "lm", "problem": "rk4"},
        {"label": "DE", "optimizer": "de", "seed": 5},
        {"label": "DE", "optimizer": "de", "seed": 5, "problem": "rk4"},
        {"label": "Mine", "seed": [1, 2]},
        {"label": "Mine", "problem": "rk4"},
    ]
    assert len(grid_points(blocks, {}, set())) == 8


def test_a_cross_alone_is_a_grid():
    assert grid_blocks([], [], [{"seed": [1, 2]}]) == [{"seed": [1, 2]}]
    assert grid_blocks([], [], []) == [{}]


def test_labels_choose_lines_in_the_order_of_the_grid():
    assert [block["label"] for block in labelled(LINES, ["DE"])] == [["DE"]]
    assert [block["label"] for block in labelled([*LINES, {}], ["DE", "LM"])] == [["LM"], ["DE"]]
    assert labelled([{"label": ["A", "B"]}, {"label": 3}], ["B", "3"]) == [{"label": ["B"]}, {"label": [3]}]


def test_a_label_that_is_none_is_refused_with_the_nearest():
    with pytest.raises(SettingError, match=r"label.*'KSME'.*did you mean 'KSMEA'"):
        labelled([{"label": "KSMEA"}, {"label": "LM"}], ["LM", "KSME"])
    with pytest.raises(SettingError, match=r"^label: expected an experiment whose grid has labels, got label=LM"):
        labelled([{"samples": 40}], ["LM"])
