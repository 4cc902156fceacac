"""Settings by the source of plugins, against the plugins themselves."""

import pytest

from bench.command_line.bench_settings import bench_fields, default_plugins
from bench.command_line.source_settings import source_settings
from ksmea.plugins import registry
from ksmea.settings.settings import own_fields

ALL = [(group, name) for group in registry.GROUPS | registry.FURTHER for name in registry.registered(group)]


@pytest.mark.parametrize("group, name", ALL)
def test_names_and_choices_are_those_of_the_plugin(group, name):
    found = source_settings(group, name)
    fields = own_fields(registry.plugin_class(group, name))
    assert [*found] == [field.name for field in fields]
    for field in fields:
        told = found[field.name].choices
        assert told in ((), tuple(field.metadata.get("choices", ())))


def test_most_choices_are_told():
    fields = [(pair, field) for pair in ALL for field in own_fields(registry.plugin_class(*pair))]
    choosing = [(pair, field.name) for pair, field in fields if field.metadata.get("choices")]
    told = [1 for pair, name in choosing if source_settings(*pair)[name].choices]
    assert len(told) > 0.7 * len(choosing)  # the others are computed


def test_what_has_no_source_is_not_told():
    assert source_settings("optimizer", "nobody") is None


def test_every_setting_of_the_bench_has_its_help_or_is_a_group():
    helped = {name for name, field in bench_fields().items() if field.metadata.get("help")}
    assert bench_fields().keys() - helped == registry.GROUPS.keys() == default_plugins().keys()
    samples = bench_fields()["samples"]
    assert samples.default == 100 and "samples of a surrogate" in samples.metadata["help"]
