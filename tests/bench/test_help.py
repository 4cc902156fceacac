"""Help: every plugin and every setting with its default, and nothing that has to be kept up to date by hand."""

import dataclasses
from importlib.metadata import entry_points

import pytest

from bench.storage.own_files import CONF
from ksmea.plugins import registry
from ksmea.settings.settings import own_fields

PLUGINS = [(group, point.name) for group, name in registry.GROUPS.items() for point in entry_points(group=name)]
WORDS = {None: "null", True: "true", False: "false"}


def default_of(field):
    value = field.default if field.default is not dataclasses.MISSING else field.default_factory()
    return WORDS[value] if value is None or isinstance(value, bool) else str(value)


def test_the_first_page_names_experiments_plugins_and_settings(enter):
    page = enter("help")
    assert (page.code, page.err) == (0, "")
    for group, name in PLUGINS:
        [line] = [line for line in page.out.splitlines() if line.strip().startswith(f"{group}=")]
        assert name in line.partition("=")[2].replace("|", " ").split()
    for path in (CONF / "experiment").glob("*.yaml"):
        assert path.stem in page.out
    for setting in ("samples", "repetitions", "seed", "output", "workers", "timeout", "batches"):
        assert setting in page.out.partition("settings of every experiment:")[2].splitlines()[0].split()
    assert "BENCH_TRACEBACK=1" in page.out
    assert enter("--help").out == enter("-h").out == page.out


@pytest.mark.parametrize("group, name", PLUGINS)
def test_every_setting_of_every_plugin_with_its_default(group, name, enter):
    page = enter("help", group, name)
    assert (page.code, page.err) == (0, "")
    head, *lines = page.out.splitlines()
    assert head.startswith(f"{group}={name}: ") and len(head) > len(f"{group}={name}: ") + 10
    fields = own_fields(registry.plugin_class(group, name))
    assert len(lines) == len(fields)
    for field, line in zip(fields, lines):
        assert line.strip().startswith(f"{group}.{field.name}={default_of(field)}  ")
        assert " ".join(field.metadata["help"].split()) in " ".join(line.split())
        for choice in field.metadata["choices"]:
            assert choice in line
    assert page.out in enter("help", group).out


def test_units_ranges_and_sources(enter):
    page = enter("help", "optimizer", "de").out
    [line] = [line for line in page.splitlines() if "optimizer.mutation_factor" in line]
    assert "=0.8 " in line and "above 0 and at most 1.99" in line and "Table 5" in line
    assert "[µm]" in enter("help", "measurement").out


@pytest.mark.parametrize(
    "words, expected",
    [
        (["optimiser"], "unknown name 'optimiser'; did you mean 'optimizer'?"),
        (["optimizer", "dee"], "unknown optimizer 'dee'; did you mean 'de'?"),
    ],
)
def test_help_on_what_is_not_there(words, expected, enter):
    page = enter("help", *words)
    assert page.code == 2 and page.out == "" and page.err.startswith(f"error: {expected}")


def test_an_unknown_name_is_told_the_nearest_few_and_where_all_are(enter):
    said = enter("help", "tabel3").err
    assert "did you mean 'table3'? also near: table, " in said and "python -m bench help lists" in said
    assert len(said) < 300 and "help table3" in said
    assert "did you mean" not in enter("help", "xyzzyx").err


def test_plugins_from_outside_with_their_package_and_whether_they_load(enter, tmp_path, monkeypatch):
    """One that loads, one that does not, and one whose name is that of a plugin of this project."""
    information = tmp_path / "their_tools-1.5.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: their-tools\nVersion: 1.5\n")
    points = "good = optimizers.pso:PSO\nbad = nothing_of_this_name:Bad\nde = optimizers.pso:PSO\n"
    (information / "entry_points.txt").write_text(f"[ksmea.optimizers]\n{points}")
    monkeypatch.syspath_prepend(tmp_path)
    registry.registered.cache_clear()
    try:
        page = enter("help").out.partition("plugins from outside:\n")[2].splitlines()
        group = enter("help", "optimizer").out
    finally:
        registry.registered.cache_clear()
    reason = "ModuleNotFoundError: No module named 'nothing_of_this_name'"
    assert page == [
        f"  optimizer=bad: from their-tools 1.5; cannot be chosen: nothing_of_this_name:Bad cannot be loaded: {reason}",
        "  optimizer=good: from their-tools 1.5; loads",
        "  optimizer=de: from their-tools 1.5; left out, ksmea-bench has one of this name: rename it there",
    ]
    assert f"{reason} [their-tools 1.5]" in group
    assert group.count("[their-tools 1.5]") == 2 and "[ksmea-bench " in group
