"""Which values the command line's words give the settings."""

import pytest
from hydra.errors import OverrideParseException

from bench.command_line.overrides import as_given, for_some_plugins, parse
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
        ("samples=range(40,201,40)", "samples", (40, 80, 120, 160, 200)),
        (
            "measurement.relative=range(0.05,0.2,0.05)",
            "measurement.relative",
            (0.05, 0.1, 0.15),
        ),  # as one would write them
        ("samples=sort(70,40,50)", "samples", (40, 50, 70)),
        ("optimizer=glob([d*,p*],exclude=dual*)", "optimizer", ("de", "pso")),
        ("optimizer=glob(nothing*)", "optimizer", ()),
    ],
)
def test_a_word_of_the_command_line(word, key, expected):
    assert values(word) == {key: expected}
    assert [type(value) for value in values(word)[key]] == [type(value) for value in expected]


def test_the_last_word_on_a_setting_wins():
    assert values("samples=40", "seed=1", "samples=70,80") == {"samples": (70, 80), "seed": (1,)}


@pytest.mark.parametrize(
    "word, line",
    [
        ("samples=interval(40,70)", r"samples: expected a value, a list a,b,c or range\(from,to,step\), got interval"),
        ("samples=shuffle(40,70)", r"samples: expected values in an order that stays, got shuffle\(40,70\)"),
        ("samples=range(40,70,0)", r"samples: expected a step other than 0, got range\(40,70,0\)"),
        ("samples=glob(*)", r"samples: expected values, got glob\(\*\); glob chooses plugins, of problem, "),
    ],
)
def test_what_gives_no_values_or_no_order_is_refused(word, line):
    with pytest.raises(SettingError, match=f"^{line}"):
        parse([word])


def test_a_word_comes_back_from_the_sweeper_as_it_was_typed():
    words = ["optimizer.lm.screening=null", "optimizer.de.population=[1,2]", "surrogate.krig=1", "samples=40"]
    left = for_some_plugins(["optimizer=de,lm", *words], ["optimizer"])
    assert [choice.values for choice in parse(left)][1:] == [(None,), ([1, 2],), (1,), (40,)]
    assert list(map(as_given, left)) == ["optimizer=de,lm", *words]


def test_an_unbalanced_bracket_is_refused():
    with pytest.raises(OverrideParseException):
        parse(["problem.sensors=[0.1"])
