"""Plugins in plain files: their names, what they bring along, and those that cannot be used."""

import sys

import pytest

from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.plugins.files import brought_along, digests, plugins_of_file
from optimizers.de import DE
from outside_package import plain_files

PLUGIN = '''
from dataclasses import dataclass
from ksmea import Optimizer


class _Base(Optimizer):
    """What others are made of."""


@dataclass(frozen=True)
class GridSearch(_Base):
    """The middle of the unit cube."""

    def minimize(self, objective, rng):
        return objective.result()
'''


@pytest.fixture
def file(tmp_path):
    """A file of a plugin, written and forgotten afterwards."""

    def written(content=PLUGIN, name="my_search.py"):
        (tmp_path / name).write_text(content)
        return tmp_path / name

    with plain_files(tmp_path):
        yield written


def test_every_public_class_of_a_contract_is_a_plugin_named_as_the_class(file):
    path = file(PLUGIN + PLUGIN.replace("GridSearch", "RK4Two"))
    assert [(each.group, each.name) for each in plugins_of_file(path)] == [
        ("optimizer", "grid_search"),
        ("optimizer", "rk4_two"),
    ]


def test_it_is_registered_beside_the_installed_ones(file):
    path = file()
    registry.register_file(path)
    registry.register_file(path)  # once more changes nothing
    assert [*registry.registered("optimizer")] == sorted(registry.registered("optimizer"))
    assert registry.create("optimizer", "grid_search", {}).minimize
    assert type(registry.create("optimizer", "de", {})) is DE
    assert registry.origin("optimizer", "grid_search") == str(path)


@pytest.mark.parametrize(
    "name, content, expected",
    [
        (
            "my_search.py",
            "import nothing_of_this_name",
            "cannot be loaded: ModuleNotFoundError: No module named 'nothing",
        ),
        ("my_search.py", "def search(:", "cannot be loaded: SyntaxError: "),
        ("my_search.py", "raise SystemExit(3)", "cannot be loaded: SystemExit: 3"),
        ("my_search.py", "from ksmea import Optimizer", "expected a class that subclasses one of ProblemSettings,"),
        ("my_search.py", PLUGIN.replace("GridSearch", "DE"), "optimizer=de is there from ksmea-bench "),
        ("random.py", PLUGIN, "expected a name that no other module has, but Python takes random from "),
        ("numpy.py", PLUGIN, "expected a name that no other module has, but Python takes numpy from "),
        (
            "my-search.py",
            PLUGIN,
            "expected a file named as a module is, as my_optimizer.py, got my-search.py; rename it",
        ),
    ],
)
def test_one_that_cannot_be_used_is_told_in_one_line_and_leaves_nothing_behind(file, name, content, expected):
    before = {group: [*registry.registered(group)] for group in registry.GROUPS | registry.FURTHER}
    with pytest.raises(SettingError) as caught:
        registry.register_file(file(content, name))
    assert str(caught.value).startswith("plugins: ") and expected in str(caught.value)
    assert "\n" not in str(caught.value)
    assert {group: [*registry.registered(group)] for group in before} == before


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(SettingError, match=r"expected a Python file, found none at .*absent.py"):
        registry.register_file(tmp_path / "absent.py")


def test_what_it_imports_from_beside_it_counts_and_nothing_is_executed(file, tmp_path):
    path = file("import numpy, json, ksmea\nimport one\nraise SystemExit")
    file("import importlib\nimportlib.import_module('both.inner')\nraise SystemExit", "one.py")
    (tmp_path / "both").mkdir()
    for name in ("both/__init__.py", "both/inner.py", "both/table.csv", "json.py", "alone.py"):
        file("", name)
    assert [*brought_along(path)] == ["both/__init__.py", "both/inner.py", "both/table.csv", "my_search.py", "one.py"]
    before = digests(path)
    file("1", "both/table.csv")
    now = digests(path)
    assert {name for name in now if now[name] != before[name]} == {"both/table.csv"}
    assert "one" not in sys.modules


def test_two_files_cannot_bring_modules_of_one_name(file, tmp_path):
    (tmp_path / "other").mkdir()
    for folder in ("", "other/"):
        file("", f"{folder}shared.py")
        file(f"import shared\n{PLUGIN}".replace("GridSearch", f"G{len(folder)}"), f"{folder}search{len(folder)}.py")
    registry.register_file(tmp_path / "search0.py")
    with pytest.raises(SettingError, match=r"Python takes shared from .*; rename it"):
        registry.register_file(tmp_path / "other" / "search6.py")


def test_in_a_worker_it_is_what_was_planned_or_refused(file):
    path = file()
    planned = digests(path)
    path.write_text(PLUGIN + "# another remark\n")
    with pytest.raises(SettingError, match=r"my_search.py has changed; give the experiment's command again"):
        registry.register_file(path, planned)
    registry.register_file(path, digests(path))


def test_a_package_without_init_counts_too_where_it_is_what_python_takes(file, tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "numpy").mkdir()  # a folder that has the name of an installed package is no package
    file("COUNT = 2", "parts/counts.py")
    file("", "numpy/notes.txt")
    path = file(f"import numpy.linalg\nfrom parts.counts import COUNT\n{PLUGIN}")
    assert [*brought_along(path)] == ["my_search.py", "parts/counts.py"]
    registry.register_file(path)
