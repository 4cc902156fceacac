"""Plugins by name, and the errors that speak to the user."""

import dataclasses
from pathlib import Path

import pytest

from ksmea import registry
from ksmea.errors import SettingError, unknown
from ksmea.settings import Settings

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
    ("measurement", "file"): {"path": str(EXAMPLES / "run_up.csv")},
}


@pytest.mark.parametrize("group", KNOWN)
def test_what_comes_with_the_project_is_registered_in_alphabetical_order(group):
    names = list(registry.registered(group))
    assert set(names) >= KNOWN[group]
    assert names == sorted(names)


@pytest.mark.parametrize("group, name", PLUGINS)
def test_every_plugin_is_frozen_settings_whose_defaults_can_be_used(group, name):
    required = REQUIRED.get((group, name), {})
    plugin = registry.create(group, name, required)
    assert isinstance(plugin, Settings) and isinstance(plugin, registry.plugin_class(group, name))
    assert type(plugin).__dataclass_params__.frozen
    assert plugin == registry.create(group, name, required)


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
    for field in dataclasses.fields(registry.plugin_class(group, name)):
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
