"""Which values the settings take: the command line's overrides and an experiment's grid."""

import pytest
from hydra.errors import OverrideParseException

from bench.command_line.overrides import grid_points, parse
from ksmea.errors import SettingError


def values(*words):
    return {choice.key: choice.values for choice in parse(list(words))}


@pytest.mark.parametrize(
    "word, key, expected",
    [
        ("samples=40", "samples", (40,)),
        ("samples=40,70", "samples", (40, 70)),
        ("measurement.relative=0,0.05,1e-3", "measurement.relative", (0, 0.05, 1e-3)),
        ("optimizer=de,pso", "optimizer", ("de", "pso")),
        ("+experiment=table3", "experiment", ("table3",)),
        ("++optimizer.population=30", "optimizer.population", (30,)),
        ("problem.limits.kxx=[10,90]", "problem.limits.kxx", ([10, 90],)),
        ("problem.sensors=[0.1],[0.1,0.2]", "problem.sensors", ([0.1], [0.1, 0.2])),
        ("timeout=null", "timeout", (None,)),
        ("method.polish=true,false", "method.polish", (True, False)),
        ("output='a=b, c'", "output", ("a=b, c",)),
        ("name='40'", "name", ("40",)),
        ("samples=choice(40,70)", "samples", (40, 70)),
        ("~optimizer", "optimizer", ()),
    ],
)
def test_a_word_of_the_command_line(word, key, expected):
    assert values(word) == {key: expected}
    assert [type(value) for value in values(word)[key]] == [type(value) for value in expected]


def test_the_last_word_on_a_setting_wins():
    assert values("samples=40", "seed=1", "samples=70,80") == {"samples": (70, 80), "seed": (1,)}


def test_a_continuous_interval_is_no_sweep():
    with pytest.raises(SettingError, match=r"^samples: expected a value or a list a,b,c, got interval"):
        parse(["samples=interval(40,70)"])


def test_an_unbalanced_bracket_is_refused():
    with pytest.raises(OverrideParseException):
        parse(["problem.sensors=[0.1"])


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
