"""Statements on results and settings are true.

Results that nobody can judge are not done, no value is dropped in silence, no method counts twice.
"""

import json

import pytest

from bench.plan.plan import question_of

CHEAP = ["method=direct", "optimizer=random_search", "optimizer.evaluations=100", "repetitions=1", "workers=1"]


@pytest.fixture
def done(enter, tmp_path):
    """A finished run whose plan then names an optimiser that is not installed."""
    ended = enter(*CHEAP)
    assert ended.code == 0 and enter("status", "run").code == 0
    lines = [json.loads(line) for line in (ended.output / "plan.jsonl").read_text().splitlines()]
    for line in lines:
        if line["line"] == "cell":
            line["settings"]["optimizer"]["name"] = "theirs"
            settings, seed = line["settings"], line["seed"]
        elif line["line"] == "run":
            line["question"] = question_of(settings, seed, line["repetition"])
    (ended.output / "plan.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    return ended


def test_a_result_of_a_plugin_that_is_not_here_is_not_done(done, enter):
    status = enter("status", "run")
    assert status.code == 1
    assert "       done      0" in status.out
    assert "    unknown      1  (unknown optimizer 'theirs'; known: chain," in status.out


def test_a_name_of_two_packages_cannot_be_told_either(done, enter, monkeypatch):
    from importlib.metadata import EntryPoint

    from ksmea.plugins import names, registry

    point = EntryPoint("theirs", "one:Theirs", "ksmea.optimizers")
    shared = names.SharedName([point, EntryPoint("theirs", "two:Theirs", "ksmea.optimizers")])
    known = dict(registry.registered("optimizer")) | {"theirs": shared}
    monkeypatch.setattr(
        registry, "registered", lambda group: known if group == "optimizer" else names.registered(group)
    )
    status = enter("status", "run")
    assert (
        status.code == 1
        and "unknown      1  (optimizer=theirs: expected one package that registers this name" in status.out
    )


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (
            ["problem.limits={kxx: [10, 90]}", "problem.limits={kyy: [10, 90]}"],
            "problem.limits: expected one mapping, got problem",
        ),
        (
            ["output=n_${problem.n_speed}", "problem.n_speed=20,30"],
            "output: expected one output for the whole experiment, got ${problem",
        ),
        (
            ["output=o_${optimizer.name}", "optimizer=de,pso"],
            "output: expected one output for the whole experiment, got ${optimizer.name}",
        ),
        (["name=n_${seed}", "grid=[{seed: [1, 2]}]"], "name: expected one name for the whole experiment, got ${seed}"),
    ],
)
def test_a_value_that_would_be_dropped_or_taken_for_all_is_refused(words, line, enter, tmp_path):
    ended = enter(*words, "table=settings", "repetitions=0")
    assert ended.code == 2 and line in ended.err and ended.err.count("\n") == 1 and not [*tmp_path.iterdir()]


def test_a_folder_may_be_named_by_a_setting_of_one_value(enter):
    ended = enter("output=n_${problem.n_speed}", "problem.n_speed=20", "table=settings", "repetitions=0", output="n_20")
    assert ended.code == 0 and ended.output.is_dir()


@pytest.mark.slow
def test_a_method_without_an_optimiser_counts_once(enter, tmp_path):
    (tmp_path / "plain.py").write_text(
        "from dataclasses import dataclass\nfrom ksmea import Method\nfrom ksmea.identification.direct import Direct\n"
        "from optimizers.random_search import RandomSearch\n\n\n@dataclass(frozen=True)\nclass PlainSearch(Method):\n"
        '    """A search with an optimiser of its own."""\n\n    def identify(self, *given):\n'
        "        return Direct(RandomSearch()).identify(*given)\n"
    )
    words = ["plugins=[plain.py]", "method=direct,plain_search", "optimizer=random_search,nelder_mead"]
    ended = enter(*words, "repetitions=1", "workers=1")
    places = [(cell["place"]["method"], cell["place"]["optimizer"]) for cell in ended.cells()]
    assert places == [("direct", "random_search"), ("direct", "nelder_mead"), ("plain_search", None)]
    assert len(ended.runs()) == 3
