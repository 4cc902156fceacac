"""The exams of `ksmea.testing`: what comes with the project passes, and what breaks a property is told which and why."""

import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

from broken_methods import BROKEN_MEASUREMENTS, BROKEN_METHODS, shipped
from broken_optimizers import BROKEN_OPTIMIZERS, Shrinking
from broken_problems import BROKEN_EFFECTS, BROKEN_PROBLEMS, Rotor, Shift
from broken_surrogates import BROKEN_SURROGATES, FittedTruth, Radial
from filled_pages import filled
from ksmea import testing
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.testing.exam import sit
from ksmea.testing.optimizer import finds_the_minimum_of_a_sphere
from measurements.synthetic import Synthetic
from optimizers.lm import LM
from problems.rotor_file import RotorFile
from problems.three_disk import ThreeDisk
from surrogates.kriging import Kriging
from tiers import mostly_slow

DOCS = Path(__file__).parents[1] / "docs"
EXAMPLES = DOCS / "examples"
PAGE = filled((DOCS / "plugins.md").read_text(encoding="utf-8"))
ROTOR = RotorFile(file=str(EXAMPLES / "rotor.yaml"))
PARTS = {"surrogate": Kriging(), "optimizer": LM(screening=500, starts=3), "samples": 40}  # what methods are made of
REQUIRED = {  # settings without which a plugin says nothing
    "extended": {"file": str(EXAMPLES / "extended.yaml")},
    "rotor": {"file": str(EXAMPLES / "rotor.yaml")},
    "campaign": {"path": str(EXAMPLES / "campaign.yaml")},
    "file": {"path": str(EXAMPLES / "run_up.csv")},
    "local_force": {"position": 0.5},
}
STATED = {  # what a plugin is known to reach, and what it is tried with, where that is not what its exam takes
    "rsm": {"at_samples": 0.3},  # 21 terms, least squares
    "random_search": {"distance": 0.2},  # the best of 10 000 points in five dimensions
    "campaign": {"of": ROTOR},
    "file": {"of": ROTOR},
}
TRIED = {"effect": {"on": ThreeDisk(sensors=[0.1, 0.2, 0.5], n_speed=7)}}
EXAMS = {group: getattr(testing, f"check_{group}") for group in registry.CONTRACTS if group not in ("study", "report")}
SHIPPED = [(group, name) for group in EXAMS for name in registry.registered(group)]
COSTLY = [("optimizer", name) for name in ("chain", "cmaes", "dual_annealing", "nelder_mead")] + [("surrogate", "gpr")]
EFFECTS = [("effect", name) for name in ("clearance_rub", "residual_bow", "runout", "unbalance", "youngs_modulus")]
EACH = mostly_slow(SHIPPED, but=[pair for pair in SHIPPED if pair[0] != "effect" and pair not in COSTLY] + EFFECTS)
GOOD = {  # made to keep every property; the others are made of them
    "optimizer": (Shrinking(), {}),
    "surrogate": (Radial(), {}),
    "problem": (Rotor(), {}),
    "effect": (Shift(), {"on": Rotor(problem="Massive")}),
    "method": (shipped(), {}),
    "measurement": (Synthetic(relative=0.05), {}),
}
BROKEN = [
    *(("optimizer", *broken) for broken in BROKEN_OPTIMIZERS),
    *(("surrogate", *broken) for broken in BROKEN_SURROGATES),
    *(("problem", *broken) for broken in BROKEN_PROBLEMS),
    *(("effect", *broken) for broken in BROKEN_EFFECTS),
    *(("method", *broken) for broken in BROKEN_METHODS),
    *(("measurement", *broken) for broken in BROKEN_MEASUREMENTS),
]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("group, name", EACH, ids=[" ".join(pair) for pair in SHIPPED])
def test_what_comes_with_the_project_passes(group, name):
    plugin = registry.create(group, name, REQUIRED.get(name, {}), PARTS)
    EXAMS[group](plugin, **(TRIED.get(group, {}) | STATED.get(name, {})))


@pytest.mark.filterwarnings("error")
def test_a_machine_with_tables_supports_and_probes_on_housings_passes():
    testing.check_problem(RotorFile(file=str(EXAMPLES / "machine.yaml")))


@pytest.mark.parametrize("group", ["surrogate", "problem", "effect"])  # the others pass above and below
def test_what_the_broken_ones_are_made_of_passes(group):
    plugin, stated = GOOD[group]
    EXAMS[group](plugin, **stated)


@pytest.mark.parametrize("group, kept, plugin, message", BROKEN, ids=[f"{each[0]} {each[1]}" for each in BROKEN])
def test_what_breaks_a_property_is_told(group, kept, plugin, message):
    case = EXAMS[group].case(plugin, **GOOD[group][1])
    by_name = {each.__name__: each for each in EXAMS[group].properties(case)}
    with pytest.raises(testing.ExamFailed, match=message) as failed:
        sit(by_name[kept], case)
    assert "\n" not in str(failed.value)


def test_every_property_is_broken_by_one():
    cases = [EXAMS[group].case(plugin, **stated) for group, (plugin, stated) in GOOD.items()]
    cases.append(EXAMS["surrogate"].case(FittedTruth()))
    properties = {
        kept.__name__ for group, case in zip([*GOOD, "surrogate"], cases) for kept in EXAMS[group].properties(case)
    }
    assert properties == {kept for _, kept, *_ in BROKEN}


def test_a_script_is_told_all_that_fails():
    with pytest.raises(testing.ExamFailed) as failed:
        testing.check_optimizer(Shrinking(rounds=1), evaluations=10, distance=0.01)
    first, *others = str(failed.value).split("\n")
    assert first == "Shrinking fails 2 of 18 properties"
    assert [line.partition(":")[0] for line in others] == [
        "survives_points_without_value",
        "finds_the_minimum_of_a_sphere",
    ]


@pytest.mark.parametrize("given", [Shrinking, Radial(), None])
def test_what_is_no_instance_of_the_kind_is_refused(given):
    with pytest.raises(
        SettingError, match=r"expected an instance of a subclass of ksmea\.Optimizer, got .*hand over Mine"
    ):
        testing.check_optimizer(given)


BROKEN_TOO = """
from broken_optimizers import OwnResult

test_broken = check_optimizer.tests(OwnResult())
"""


@pytest.fixture
def package(tmp_path):
    """A folder with the files of docs/plugins.md, whose tests sit an optimiser that fails beside the page's."""
    for name, content in re.findall(r"```python\n# (\S+)\n(.*?)```", PAGE, re.DOTALL):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content + (BROKEN_TOO if name.startswith("tests/") else ""))
    return tmp_path


def test_one_line_of_a_test_file_is_a_test_for_each_property(package):
    paths = f"pythonpath=. '{Path(__file__).parent / 'helpers'}'"
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-rA",
        "-p",
        "no:cacheprovider",
        "--rootdir",
        ".",
        "-o",
        paths,
        "tests",
    ]
    run = subprocess.run(command, cwd=package, capture_output=True, text=True, timeout=120, check=False)
    assert "1 failed, 35 passed" in run.stdout, run.stdout
    where = "tests/test_uniform_search.py::test_"
    assert f"PASSED {where}uniform_search[ends_with_its_budget]" in run.stdout
    assert f"FAILED {where}broken[returns_the_objectives_result]" in run.stdout
    assert "end with return objective.result()" in run.stdout


def test_the_page_quotes_what_a_script_is_told(package, monkeypatch):
    monkeypatch.syspath_prepend(package)
    case = testing.check_optimizer.case(importlib.import_module("my_package.uniform_search").UniformSearch())
    with pytest.raises(testing.ExamFailed) as failed:
        sit(finds_the_minimum_of_a_sphere, case)
    assert f"\nfinds_the_minimum_of_a_sphere: {failed.value}\n" in PAGE


def test_the_page_names_every_property():
    named = set(re.findall(r"`([a-z]+(?:_[a-z]+)+)`", PAGE.partition("## Properties")[2]))
    assert {kept for _, kept, *_ in BROKEN} <= named


def test_only_who_asks_for_tests_needs_pytest():
    code = "import sys, ksmea; assert 'ksmea.testing' not in sys.modules; import ksmea.testing; assert 'pytest' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
