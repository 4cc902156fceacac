"""Plugins by name, and the errors that speak to the user."""

import dataclasses
from pathlib import Path

import pytest

from ksmea.errors import SettingError, unknown
from ksmea.plugins import registry
from ksmea.settings.settings import Settings, own_fields
from optimizers.de import DE
from surrogates.rsm import ResponseSurface

PLUGINS = [(group, name) for group in registry.GROUPS for name in registry.registered(group)]
KNOWN = {
    "problem": {"three_disk"},
    "measurement": {"synthetic"},
    "surrogate": {"kriging", "none", "rsm"},
    "optimizer": {"de", "ga", "lm", "pso"},
    "method": {"direct", "ksmea"},
}


def refusal(call, *arguments):
    with pytest.raises(SettingError) as caught:
        call(*arguments)
    assert "\n" not in str(caught.value)
    return str(caught.value)


# The settings that have no default: whose rotor it is, and what was measured.
EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
REQUIRED = {
    ("problem", "rotor"): {"file": str(EXAMPLES / "rotor.yaml")},
    ("problem", "extended"): {"file": str(EXAMPLES / "extended.yaml")},
    ("measurement", "campaign"): {"path": str(EXAMPLES / "campaign.yaml")},
    ("measurement", "file"): {"path": str(EXAMPLES / "run_up.csv")},
}
PARTS = {"surrogate": ResponseSurface(), "optimizer": DE(), "samples": 40}  # what methods are made of


@pytest.mark.parametrize("group", KNOWN)
def test_what_comes_with_the_project_is_registered_in_alphabetical_order(group):
    names = list(registry.registered(group))
    assert set(names) >= KNOWN[group]
    assert names == sorted(names)


@pytest.mark.parametrize("group, name", PLUGINS)
def test_every_plugin_is_frozen_settings_whose_defaults_can_be_used(group, name):
    required = REQUIRED.get((group, name), {})
    plugin = registry.create(group, name, required, PARTS)
    assert isinstance(plugin, Settings) and isinstance(plugin, registry.plugin_class(group, name))
    assert type(plugin).__dataclass_params__.frozen
    assert plugin == registry.create(group, name, required, PARTS)


@pytest.mark.parametrize("group, name", PLUGINS)
def test_every_setting_of_every_plugin_tells_what_it_is(group, name):
    plugin = registry.plugin_class(group, name)
    assert plugin.__doc__ and not plugin.__doc__.startswith(plugin.__name__ + "(")  # not the one dataclass makes
    for field in dataclasses.fields(plugin):
        assert field.metadata.get("help", "").strip(), f"{group}={name}: {field.name} has no help text"


@pytest.mark.parametrize("group, name", PLUGINS)
def test_an_unknown_setting_is_refused_with_the_known_ones(group, name):
    text = refusal(registry.create, group, name, {"no_such_setting": 1})
    assert text.startswith(f"unknown setting of {group}={name}: 'no_such_setting'")
    for field in own_fields(registry.plugin_class(group, name)):
        assert field.name in text


def test_an_unknown_plugin_is_refused_with_the_nearest_first():
    text = refusal(registry.create, "surrogate", "krigin", {})
    assert text == "unknown surrogate 'krigin'; did you mean 'kriging'? known: " + ", ".join(
        registry.registered("surrogate")
    )


def test_a_mistyped_setting_is_refused_with_the_nearest_first():
    assert "did you mean 'crossover_rate'? known: " in refusal(registry.create, "optimizer", "de", {"crossover": 0.5})


def test_settings_reach_the_plugin():
    assert registry.create("optimizer", "de", {"generations": 7}).generations == 7


def test_a_value_out_of_range_names_the_plugin_too():
    text = refusal(registry.create, "optimizer", "de", {"population": 2})
    assert text == "optimizer=de: population: expected a number at least 5, got 2"


def test_nothing_like_it_gets_no_hint():
    assert str(unknown("optimizer", "xyz", ["de"])) == "unknown optimizer 'xyz'; known: de"
    assert str(unknown("optimizer", "xyz", [])) == "unknown optimizer 'xyz'; known: none"


@dataclasses.dataclass(frozen=True)
class Unlike:
    """No plugin at all, but a frozen dataclass."""


class Registered:
    """An entry point that loads what it is given."""

    value = "mine:Plugin"

    def __init__(self, plugin):
        self.load = lambda: plugin


def refused_plugin(monkeypatch, group, plugin):
    monkeypatch.setattr(registry, "registered", lambda group: {"mine": Registered(plugin)})
    return refusal(registry.plugin_class, group, "mine")


@pytest.mark.parametrize("group", registry.CONTRACTS)
def test_a_class_that_does_not_keep_the_contract_is_refused(monkeypatch, group):
    text = refused_plugin(monkeypatch, group, Unlike)
    contract = registry.CONTRACTS[group]
    expected = (
        f"{group}=mine: expected a subclass of {contract.__module__}.{contract.__name__} at mine:Plugin, got Unlike"
    )
    assert text.startswith(expected)


def test_a_plugin_that_lacks_what_its_contract_leaves_abstract_is_refused(monkeypatch):
    @dataclasses.dataclass(frozen=True)
    class Half(registry.CONTRACTS["surrogate"]):
        def least_samples(self, d):
            return 1

    text = refused_plugin(monkeypatch, "surrogate", Half)
    assert text.startswith("surrogate=mine: expected Half to define fit, which Surrogate leaves abstract")


def test_a_method_is_made_of_the_parts_that_it_has():
    made = registry.create("method", "ksmea", {"max_updates": 3}, PARTS)
    assert (made.surrogate, made.optimizer, made.samples) == tuple(PARTS.values())
    assert made.ignores == () and made.max_updates == 3
    assert registry.create("method", "direct", {}, PARTS).ignores == ("samples", "surrogate")
    text = refusal(registry.create, "method", "ksmea", {}, {**PARTS, "optimizer": None})
    assert text.startswith("method=ksmea: expected optimizer, what searches the surrogate, got none")
    assert refusal(registry.create, "method", "direct", {"optimizer": DE()}).startswith(
        "unknown setting of method=direct"
    )


@pytest.fixture
def packages(tmp_path, monkeypatch):
    """Packages of others that register an optimiser of one name."""

    def install(name, *owners):
        for owner in owners:
            information = tmp_path / f"{owner}_tools-1.0.dist-info"
            information.mkdir()
            (information / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {owner}-tools\nVersion: 1.0\n")
            (information / "entry_points.txt").write_text(f"[ksmea.optimizers]\n{name} = optimizers.pso:PSO\n")
        monkeypatch.syspath_prepend(tmp_path)
        registry.registered.cache_clear()

    yield install
    registry.registered.cache_clear()


def test_a_name_that_two_packages_register_is_refused_with_both(packages):
    packages("mine", "one", "two")
    text = refusal(registry.create, "optimizer", "mine", {})
    assert registry.create("optimizer", "ga", {}) is not None
    assert text.startswith("optimizer=mine: expected one package that registers this name, got ")
    assert all(f"{package}-tools (optimizers.pso:PSO)" in text for package in ("one", "two"))


def test_a_name_of_this_project_stays_its_own(packages):
    """A package that registers it too is left out, and takes nothing away from whoever chooses the name."""
    packages("de", "one")
    assert type(registry.create("optimizer", "de", {})) is DE
    assert registry.origin("optimizer", "de").startswith("ksmea-bench ")
    assert [registry.origin_of(point) for point in registry.left_out("optimizer")] == ["one-tools 1.0"]
    assert registry.left_out("surrogate") == []
