"""The contest as it is planned, and a method that joins it by the words of docs/contest.md."""

import re
import shlex
from pathlib import Path

import pytest

from bench.plan.plan import read_plan
from outside_package import plain_files

PAGE = (Path(__file__).parents[2] / "docs" / "contest.md").read_text(encoding="utf-8")
FEW = ["problem.family=isotropic", "problem.instance=0,1", "repetitions=1"]
BUDGET = 60


def after(mark):
    return re.search(rf"<!-- {mark} -->\n```\w+\n(.*?)```", PAGE, re.DOTALL)[1]


@pytest.fixture
def newcomer(tmp_path):
    """The page's optimiser in a file of the working directory, and its words."""
    (tmp_path / "one_plus_one.py").write_text(after("newcomer"))
    words = shlex.split(after("newcomer's words").splitlines()[0])
    assert words[:3] == ["python", "-m", "bench"]
    with plain_files(tmp_path):
        yield [word for word in words[3:] if not word.startswith("output=")]


def instances(plan):
    """Problem, measurement and seed of each cell's runs."""
    return [(cell.settings["problem"], cell.settings["measurement"], cell.seed) for cell in plan.cells]


TWO = "grid=[{label: DE, method: direct, optimizer: de},{label: RSM, method: ksmea, surrogate: rsm, optimizer: lm, samples: 100}]"


@pytest.mark.slow
def test_a_newcomer_meets_the_instances_and_seeds_of_the_others(newcomer, enter):
    """Problem, measurement and seed, so noise, and budget are equal.

    A surrogate's samples exceed the budget here.
    """
    own = newcomer, [word if not word.startswith("grid=") else TWO for word in newcomer]
    ended = [
        enter(*words, *FEW, f"study.budget={BUDGET}", f"output={name}", output=name)
        for words, name in zip(own, ("mine", "others"))
    ]
    assert [each.code for each in ended] == [0, 0], ended[0].err
    mine, others = (read_plan(each.output) for each in ended)
    assert [cell.place["label"] for cell in mine.cells] == ["one plus one"] * 2
    assert instances(mine) * 2 == instances(others)
    assert len({cell.seed for cell in mine.cells}) == 2
    for each in ended:
        runs = each.runs()
        assert (runs["status"] == "budget").all() and (runs["model_evaluations"] == BUDGET).all()


def test_the_noise_of_a_cell_is_that_of_its_instance(newcomer, enter):
    ended = enter(*newcomer, "problem.family=two_disk", "problem.instance=0", "problem.held_back=true", "repetitions=1",
                  "study.budget=5", "output=one", output="one")  # fmt: skip
    [cell] = read_plan(ended.output).cells
    told = {key: cell.settings["measurement"][key] for key in ("family", "instance", "held_back")}
    assert told == {"family": "two_disk", "instance": 0, "held_back": True}
    assert cell.settings["problem"] == {
        "name": "drawn",
        **told,
        "machine_parts": [],
        "tolerances": "none",
        "mesh": None,
    }
