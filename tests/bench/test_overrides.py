"""Which values the command line's words give the settings."""

import pytest
from hydra.errors import OverrideParseException

from bench.command_line.overrides import parse
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
