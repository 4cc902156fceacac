"""A plugin from a plain file on the command line: chosen, set, part of the key, found by workers, jobs and commands."""

import pytest

import bench
from bench.command_line.plugin_words import given_files
from bench.jobs.execute import execute
from bench.jobs.planned_code import planned_plugins
from bench.jobs.work import Job, work
from bench.plan import outside, provenance
from bench.plan.plan import read_plan
from ksmea.errors import SettingError
from outside_package import plain_files

SEARCH = '''
from dataclasses import dataclass
from pathlib import Path

from counts import COUNT
from ksmea import Optimizer, setting

Path(__file__).with_name("executed").touch()


@dataclass(frozen=True)
class MySearch(Optimizer):
    """Random points."""

    points: int = setting(3, "points drawn, times those of a module beside", at_least=1)

    def minimize(self, objective, rng):
        objective(rng.random((self.points * COUNT, objective.dim)))
        return objective.result()
'''
EFFECT = '''
from dataclasses import dataclass
from problems.effects.runout import Runout


@dataclass(frozen=True)
class ScratchedShaft(Runout):
    """A runout by another name."""
'''
WORDS = ["optimizer=my_search", "method=direct", "repetitions=1", "study.intervals=none"]


def forget_digests():
    """A process hashes each file once."""
    outside._outside_code.cache_clear()
    provenance._used_modules.cache_clear()


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "my_search.py").write_text(SEARCH)
    (tmp_path / "mine" / "counts.py").write_text("COUNT = 2\n")
    with plain_files(tmp_path):
        yield tmp_path / "mine"
    forget_digests()


def test_it_is_chosen_and_set_as_an_installed_one(folder, enter):
    ended = enter("plugins=[mine/../mine/my_search.py]", *WORDS, "optimizer.points=5")
    assert (ended.code, ended.err) == (0, "")
    assert ended.runs()["model_evaluations"].tolist() == [10]
    assert read_plan(ended.output).plugins == {"optimizer=my_search": str(folder / "my_search.py")}


def test_commands_know_it_again_and_execute_nothing(folder, enter):
    """A folder of results may come from anywhere: no command but a run executes what its plan names."""
    ended = enter("plugins=[mine/my_search.py]", *WORDS)
    (key,) = ended.runs()["key"]
    (folder / "executed").unlink()
    with plain_files(folder):  # as in a process of its own
        for command in (["status", "run"], ["collect", "run"], ["explain", key]):
            again = enter(*command)
            assert (again.code, again.err) == (0, "")
        assert "since it was planned" not in again.out
    assert not (folder / "executed").exists()


def test_an_edit_of_what_it_imports_makes_results_stale(folder, enter):
    ended = enter("plugins=[mine/my_search.py]", *WORDS)
    (folder / "counts.py").write_text("COUNT = 3\n")
    forget_digests()  # as in a process of its own
    status = enter("status", "run")
    assert status.code == 1 and "stale      1" in status.out
    assert enter("explain", ended.runs()["key"][0]).out.splitlines()[-1].endswith(": file counts.py")


def test_a_file_that_is_gone_is_told_beside_all_else(folder, enter):
    """Results may be looked at where the plugin is not."""
    ended = enter("plugins=[mine/my_search.py]", *WORDS)
    (key,) = ended.runs()["key"]
    (folder / "my_search.py").unlink()
    forget_digests()
    status = enter("status", "run")
    assert status.code == 1 and "unknown      1" in status.out
    *lines, last = enter("explain", key).out.splitlines()
    assert any(line.startswith("done on ") for line in lines)
    assert last.startswith("the changes since it was planned are not known: plugins: expected a Python file, found")


def test_a_job_refuses_files_that_were_changed_since_the_plan(folder, enter):
    """As an installed plugin that was changed; here before the first run, in a worker before its own."""
    ended = enter("plugins=[mine/my_search.py]", *WORDS)
    (folder / "my_search.py").write_text(SEARCH + "MORE = 1\n")
    forget_digests()
    with pytest.raises(SettingError, match=r"expected the code and libraries of its plan .* file my_search.py"):
        work(Job(ended.output))
    plan = read_plan(ended.output)
    with plain_files(folder):
        record = execute(plan.cells[0].settings, plan.seeds(plan.runs[0]), plugins=planned_plugins(plan))
    assert record["status"] == "error" and "my_search.py has changed" in record["error"]


def test_an_effect_from_a_file_is_part_of_the_key_where_it_takes_part(folder, enter):
    (folder / "scratched.py").write_text(EFFECT)
    words = ["plugins=[mine/scratched.py,mine/my_search.py]", *WORDS, "measurement.kind=complex"]
    plain = enter(*words, "output=plain", output="plain")
    hidden = enter(*words, "measurement.hidden=[scratched_shaft]", "output=hidden", output="hidden")
    assert plain.code == hidden.code == 0
    assert "file scratched.py" not in read_plan(plain.output).modules
    modules = read_plan(hidden.output).modules
    assert "file scratched.py" in modules and "problems.effects.runout" in modules


def test_an_experiment_of_ones_own_names_its_files(folder, enter, tmp_path):
    (tmp_path / "own" / "experiment").mkdir(parents=True)
    text = "# @package _global_\nname: own\nplugins: [mine/my_search.py]\ngrid: [{optimizer: [my_search, lm]}]\n"
    (tmp_path / "own" / "experiment" / "mine.yaml").write_text(text)
    words = [word for word in WORDS if not word.startswith("optimizer")]
    ended = enter("+experiment=mine", "--config-dir=own", *words, output="results/own")
    assert (ended.code, ended.err) == (0, "")
    assert len(ended.runs()) == 2
    assert given_files(["+experiment=mine", "hydra.searchpath=[own]"]) == [folder / "my_search.py"]


def test_from_python_by_the_launcher_of_joblib(folder, tmp_path, monkeypatch):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher", reason="hydra-joblib-launcher is not installed")
    monkeypatch.chdir(tmp_path)
    settings = {"hydra/launcher": "joblib", "study.intervals": "none"}
    done = bench.run(
        plugins=["mine/my_search.py"],
        optimizer={"name": "my_search", "points": 4},
        method="direct",
        repetitions=2,
        batches=2,
        **settings,
    )
    assert done.failed == 0 and done.runs["model_evaluations"].tolist() == [8, 8]


@pytest.mark.parametrize(
    "words, expected",
    [
        (["plugins=mine/my_search.py"], "plugins: expected a list [a,b,...], got one value; try: "),
        (["plugins=[mine/my_serch.py]"], "plugins: expected a Python file, found none at "),
        (
            ["plugins=[mine/my_search.py]", "optimizer=my_serch"],
            "unknown optimizer 'my_serch'; did you mean 'my_search'?",
        ),
        (["plugins=[mine/my_search.py]", "optimizer.point=1"], "unknown setting 'optimizer.point'; did you mean"),
        (
            ["plugins=[mine/my_search.py]", "optimizer.points=0"],
            "optimizer=my_search: points: expected a number at",
        ),
    ],
)
def test_what_cannot_be_used_is_told_in_one_line(folder, enter, words, expected):
    ended = enter(*WORDS, *words)
    assert (ended.code, ended.out) == (2, "")
    [line] = ended.err.splitlines()
    assert line.startswith(f"error: {expected}")


def test_help_says_where_plugins_come_from_and_whether_they_load(folder, enter):
    (folder / "broken.py").write_text("import nothing_of_this_name\n")
    files = "plugins=[mine/broken.py,mine/my_search.py]"
    page = enter("help", files).out
    assert f"optimizer=my_search: from {folder / 'my_search.py'}; loads" in page
    assert f"plugins: {folder / 'broken.py'} cannot be loaded: ModuleNotFoundError" in page
    page = enter("help", files, "optimizer", "my_search", "de").out
    assert f"[{folder / 'my_search.py'}]" in page and "optimizer.points=3  points drawn" in page
    assert "[ksmea-bench " in page
