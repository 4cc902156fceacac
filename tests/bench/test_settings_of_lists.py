"""Settings given with a list of plugins, and settings of plugins that the command line cannot offer."""

import pytest

from outside_package import on_path

METADATA = "Metadata-Version: 2.1\nName: odd\nVersion: 1.0\n"
PLUGIN = '''
from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

from ksmea import Optimizer
from ksmea.settings.settings import setting


class Colour(enum.Enum):
    RED = 1


@dataclass(frozen=True)
class Inner:
    depth: int = 1


@dataclass(frozen=True)
class Odd(Optimizer):
    """Has one odd setting."""

    points: int = setting(3, "points drawn")
    odd: {hint} = {default}

    def minimize(self, objective, rng):
        objective(rng.random((self.points, objective.dim)))
        return objective.result()
'''
# Type and default of the odd setting, and what the refusal says of it.
ODD = {
    "set": ("set", "setting(frozenset(), 'a set')", "got a set"),
    "array": ("np.ndarray", "setting(None, 'an array')", "got a"),
    "none": ("int", "dataclass_field()", "expected a setting with a default, got none"),
    "enum": ("Colour", "setting(Colour.RED, 'a colour')", "got a Colour"),
    "nested": ("Inner", "setting(Inner(), 'settings of their own')", "got an Inner"),
    "mistyped": ("int", "setting(None, 'a number')", "with a default of that type, got a whole number"),
    "unresolved": ("Nowhere", "setting(1, 'of a type that is nowhere')", "types of its settings that can be resolved"),
}


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """A folder of packages, as an installer would leave it."""
    folder = tmp_path_factory.mktemp("packages")
    for name, (hint, default, _) in ODD.items():
        text = PLUGIN.replace("{hint}", hint).replace("{default}", default)
        if "dataclass_field()" in default:
            text = text.replace(
                "@dataclass(frozen=True)\nclass Odd", "@dataclass(frozen=True, kw_only=True)\nclass Odd"
            )
            text = text.replace("import dataclass", "import dataclass, field as dataclass_field")
        (folder / f"odd_{name}.py").write_text(text)
    information = folder / "odd-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text(METADATA)
    points = "\n".join(f"odd_{name} = odd_{name}:Odd" for name in ODD)
    (information / "entry_points.txt").write_text(f"[ksmea.optimizers]\n{points}\n")
    return str(folder)


@pytest.fixture
def with_odd(enter, packages, monkeypatch):
    with on_path(packages, monkeypatch):
        yield enter


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("words", [[], ["optimizer.points=5"]])
def test_a_setting_that_cannot_be_offered_is_named_where_its_plugin_is_chosen(name, words, with_odd, tmp_path):
    ended = with_odd(f"optimizer=odd_{name}", *words, "method=direct")
    assert (ended.code, ended.out) == (2, "")
    [line] = ended.err.splitlines()
    where = f"error: optimizer=odd_{name}: "
    assert (
        line.startswith(where if name == "unresolved" else f"{where}odd: expected a setting ") and ODD[name][2] in line
    )
    if name in ("set", "array", "enum", "nested"):
        assert "of type bool, int, float or str, or None, lists, tuples or mappings by name of these" in line
    assert list(tmp_path.iterdir()) == []
    assert line.removeprefix("error: ") in with_odd("help", "optimizer", f"odd_{name}").out


def test_it_takes_no_other_plugin_away(with_odd, cheapest):
    assert with_odd(*cheapest, "repetitions=1", "workers=1").code == 0
    assert with_odd("help", "optimizer").code == 0


def settings_of(ended, group="optimizer"):
    assert ended.code == 0, ended.err
    return [cell["settings"][group] for cell in ended.cells()]


def test_a_setting_given_with_a_list_goes_to_the_plugins_that_have_it(enter):
    words = ["optimizer=pso,lm", "method=direct", "optimizer.screening=64", "optimizer.starts=1", "repetitions=1"]
    pso, lm = settings_of(enter(*words, "optimizer.generations=2", "workers=1"))
    assert (pso["name"], pso["generations"]) == ("pso", 2) and "screening" not in pso
    assert (lm["name"], lm["screening"], lm["starts"]) == ("lm", 64, 1) and "generations" not in lm


def test_values_given_with_a_list_are_swept_where_the_plugin_has_the_setting(enter):
    words = ["optimizer=pso,lm", "method=direct", "optimizer.screening=64,128", "optimizer.starts=1", "repetitions=1"]
    ended = enter(*words, "optimizer.generations=2", "workers=1")
    pso, *lm = settings_of(ended)
    assert pso["name"] == "pso" and [(each["name"], each["screening"]) for each in lm] == [("lm", 64), ("lm", 128)]
    assert [cell["place"].get("optimizer.screening") for cell in ended.cells()] == [None, 64, 128]


def test_a_setting_given_with_a_grid_goes_to_the_plugins_that_have_it(enter):
    grid = "grid=[{optimizer:[pso,lm]},{samples:25}]"
    words = [grid, "method=direct", "optimizer.screening=64", "optimizer.generations=1", "optimizer.population=5"]
    found = settings_of(enter(*words, "optimizer.mutation_factor=0.7", "repetitions=1", "workers=1"))
    assert [each["name"] for each in found] == ["pso", "lm", "de"]
    assert found[1]["screening"] == 64 and found[2]["mutation_factor"] == 0.7


@pytest.mark.parametrize(
    "words, expected",
    [
        (
            ["optimizer=pso,lm", "optimizer.screning=500"],
            "unknown setting 'optimizer.screning'; did you mean 'optimizer.screening'? known: ",
        ),
        (
            ["optimizer=pso,de", "optimizer.screening=500,600"],
            "unknown setting 'optimizer.screening'; optimizer=lm has it",
        ),
        (
            ["optimizer=pso,de", "optimizer.screening=500"],
            "unknown setting 'optimizer.screening'; optimizer=lm has it",
        ),
        (
            ["optimizer=pso,de", "optimizer.population=many"],
            "optimizer.population: expected a whole number, got 'many'",
        ),
        (["optimizer=pso,nobody", "optimizer.population=5"], "unknown optimizer 'nobody'"),
        (
            ["optimizer=pso", "grid=[{optimizer:[lm]}]", "optimizer.screening=5"],
            "unknown setting 'optimizer.screening'",
        ),
    ],
)
def test_a_setting_that_none_of_them_has_is_refused(words, expected, enter, tmp_path):
    ended = enter(*words, "method=direct")
    assert (ended.code, ended.out) == (2, "")
    [line] = ended.err.splitlines()
    assert line.startswith(f"error: {expected}")
    assert list(tmp_path.iterdir()) == []
