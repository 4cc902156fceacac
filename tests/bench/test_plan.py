"""The plan: keys that tell runs apart, seeds by component, and the file."""

import dataclasses
import json
from functools import cache

import numpy as np
import pytest
from hydra import initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.types import RunMode
from omegaconf import OmegaConf

from bench.command_line.overrides import override
from bench.plan.composer import Compositions
from bench.plan.experiment import Experiment
from bench.plan.plan import all_runs, component_seeds, generator, read_plan, write_plan
from bench.plan.setup import Setup
from bench.storage.own_files import CONF
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.settings.settings import own_fields
from tiers import mostly_slow

COMPONENTS = ["noise", "design", "surrogate", "optimizer", "hidden", "diagnosis"]

# Where the rules below find no legal value: settings that hang together.
OTHER_VALUES = {
    "optimizer.bits": {"optimizer.bits": [10, 11, 11, 10, 10]},
    "surrogate.theta": {"surrogate.theta": [1.0, 1.0, 1.0, 1.0, 1.0]},
    "measurement.truth": {"measurement.truth": {"kxx": 40.0}},
    "measurement.hidden": {"measurement.hidden": ["mass"]},
    "measurement.sizes": {"measurement.hidden": ["mass"], "measurement.sizes": {"mass_change": 2.0}},
    "measurement.expected_drop": {
        "measurement.hidden": ["mass"],
        "measurement.expected_drop": 60.0,
        "measurement.relative": 0.05,
    },
    "measurement.harmonics": {
        "measurement.harmonics": [2.0],
        "measurement.kind": "complex",
        "measurement.floor": 0.1,
    },
    "measurement.runs": {"measurement.runs": ["bare", "150@0.2"]},
    "measurement.directions": {
        "measurement.runs": ["bare", "150@0.2"],
        "measurement.directions": ["up", "down"],
    },
    "method.budget": {"method.budget": 1000},
    "optimizer.first": {"optimizer.first": "ga"},
    "optimizer.then": {"optimizer.then": "lm"},
    "optimizer.first_settings": {"optimizer.first_settings": {"population": 20}},
    "optimizer.then_settings": {"optimizer.then_settings": {"evaluations": 20}},
    "study.target": {"study.target": "kyy"},
    "study.unmodelled": {
        "study.unmodelled": "auto",
        "measurement.kind": "complex",
        "problem.sensors": [0.1, 0.5],
    },
}
WITHOUT_DEFAULTS = {  # nothing without a file
    ("problem", "rotor"),
    ("problem", "extended"),
    ("measurement", "campaign"),
    ("measurement", "file"),
}


@pytest.fixture(scope="module")
def loader():
    with initialize_config_dir(str(CONF), version_base="1.3"):
        yield GlobalHydra.instance().config_loader()


@pytest.fixture(scope="module")
def compose(loader):
    """The plan that a command line means."""
    master = loader.load_configuration("config", overrides=[], run_mode=RunMode.MULTIRUN)
    return cache(lambda *words: Experiment.compose(Compositions(loader, master), list(words)).plan)


def another(group, field):
    """A block of the grid that gives this setting another legal value than its default."""
    key = f"{group}.{field.name}"
    block = OTHER_VALUES[key] if key in OTHER_VALUES else {key: another_value(field)}
    return {name: [value] for name, value in block.items()}  # bare, a list would be an axis


def another_value(field):
    default = field.default if field.default is not dataclasses.MISSING else field.default_factory()
    lowest, highest = field.metadata.get("at_least"), field.metadata.get("at_most")
    match default:
        case _ if field.metadata.get("choices"):
            other = next(choice for choice in field.metadata["choices"] if choice != default)
            return [other] if isinstance(default, list) else other
        case bool():
            return not default
        case None if "list" in field.type:
            return [0.125]
        case None if "bool" in field.type:
            return True
        case None:
            return 60 if "int" in field.type else 0.5
        case int():
            return default - 1 if default == highest else default + 1
        case float():
            return 0.25 if default == lowest == 0 else default * (1.0625 if highest is None else 0.9375)
        case str():
            return default + "x"
        case dict():
            name, (lower, upper) = next(iter(default.items()))
            return {name: [lower, 0.9375 * upper]}
        case list() if isinstance(default[0], str):
            return default[:1] if len(default) > 1 else ["y"]
        case list():
            return [1.25 * entry for entry in default]


def settings_of_every_plugin(groups, study):
    for group in groups:
        for name in [study] if group == "study" else registry.registered(group):
            if (group, name) not in WITHOUT_DEFAULTS:
                for field in own_fields(registry.plugin_class(group, name)):
                    yield group, name, field


OF_DATA = ("problem", "measurement", "study")
STUDIES = [("identify", registry.GROUPS), ("identifiability", OF_DATA), ("plan", OF_DATA)]


@pytest.mark.parametrize(("study", "groups"), mostly_slow(STUDIES, but=["identify"]))
def test_the_key_changes_with_every_setting_of_every_plugin(study, groups, compose):
    noisy = {} if study == "identify" else {"measurement.floor": 0.5}  # which the others cannot do without
    blocks = [noisy]
    for group, name, field in settings_of_every_plugin(groups, study):
        own_noise = {} if (group, name) == ("measurement", "drawn") else noisy
        blocks.append({**own_noise, group: name, **another(group, field)})
    plan = compose("repetitions=1", "samples=100", f"study={study}", "grid=" + hydra_text(blocks))
    assert len(plan.runs) == len(blocks) > (60 if study == "identify" else 30)
    keys = {}
    for block, run in zip(blocks, plan.runs):
        assert run.key not in keys, f"{block} has the key of {keys[run.key]}"
        keys[run.key] = block


def hydra_text(value):
    if isinstance(value, dict):
        return "{" + ",".join(f"{key}:{hydra_text(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ",".join(map(hydra_text, value)) + "]"
    return json.dumps(value) if not isinstance(value, str) else value


@pytest.mark.parametrize("word", ["samples=101", "seed=1"])
def test_the_key_changes_with_samples_and_seed(word, compose):
    [plain], [changed] = compose("repetitions=1").runs, compose("repetitions=1", word).runs
    assert plain.key != changed.key


def test_the_key_changes_with_repetition_code_and_versions(compose):
    plan = compose("repetitions=3")
    assert len({run.key for run in plan.runs}) == 3
    [cell] = plan.cells
    other_code = dataclasses.replace(cell, code="0" * 16)
    newer = {**plan.versions, "scipy": "99.0"}
    for cells, versions in (((other_code,), plan.versions), ((cell,), newer)):
        changed = all_runs(cells, 3, versions)
        assert not {run.key for run in changed} & {run.key for run in plan.runs}
        assert [run.question for run in changed] == [run.question for run in plan.runs]


@pytest.mark.parametrize(
    "word", ["workers=1", "timeout=60", "output=elsewhere", "batches=4", "name=other", "paper=table3", "repetitions=1"]
)
def test_what_changes_no_result_leaves_the_key(word, compose):
    assert compose(word).runs[0].key == compose().runs[0].key


def test_a_value_is_the_same_whether_the_grid_the_command_line_or_a_default_says_it(compose):
    [default] = compose("repetitions=1").runs
    [said] = compose("repetitions=1", "samples=100", "optimizer=de", "optimizer.population=100").runs
    [swept, _] = compose("repetitions=1", "problem.mesh=13,21", "method.smc=0.999").runs
    [gridded] = compose("repetitions=1", "grid=[{surrogate:kriging,samples:100}]").runs
    assert default.key == said.key == swept.key == gridded.key


def test_a_group_from_the_grid_keeps_the_experiments_plain_values(compose):
    plan = compose("+experiment=table3", "optimizer=de,pso", "samples=40", "optimizer.population=30")
    assert [cell.settings["optimizer"]["name"] for cell in plan.cells] == ["de", "pso"]
    assert all(cell.settings["optimizer"]["population"] == 30 for cell in plan.cells)
    assert all(cell.settings["measurement"]["relative"] == 0.1 for cell in plan.cells)


def test_a_label_runs_its_line_alone_and_an_added_line_meets_what_all_lines_meet(compose):
    shared = "cross=[{measurement.relative: [0.05, 0.1], seed: [1, 2, 3]}]"
    whole = compose("+experiment=efficiency", shared, "add=[{label: Mine, optimizer: pso, optimizer.population: 20}]")
    alone = compose("+experiment=efficiency", shared, "label=DE,LM")
    assert len(whole.cells) == 8 * 6
    assert [cell.place["label"] for cell in alone.cells] == ["LM"] * 6 + ["DE"] * 6
    assert {run.key for run in alone.runs} < {run.key for run in whole.runs}
    mine = [cell for cell in whole.cells if cell.place["label"] == "Mine"]
    assert {(cell.seed, cell.settings["measurement"]["relative"]) for cell in mine} == {
        (seed, relative) for seed in (1, 2, 3) for relative in (0.05, 0.1)
    }
    assert all(cell.settings["optimizer"]["population"] == 20 for cell in mine)


def populations(plan):
    return [(cell.settings["optimizer"]["name"], cell.settings["optimizer"].get("population")) for cell in plan.cells]


@pytest.mark.parametrize(
    "words, expected",
    [
        (["optimizer=de,ga", "optimizer.de.population=20", "optimizer.ga.population=40"], [("de", 20), ("ga", 40)]),
        (["optimizer=lm,de", "optimizer.de.population=20,40"], [("lm", None), ("de", 20), ("de", 40)]),
        # what names a plugin says more than what does not, in whichever order
        (["optimizer=de,ga", "optimizer.de.population=20", "optimizer.population=40,60"], [("de", 20), ("ga", 40), ("ga", 60)]),
        (["optimizer=de,ga", "optimizer.de.population=20,30", "optimizer.population=40"], [("de", 20), ("de", 30), ("ga", 40)]),
        (["grid=[{optimizer: [de, ga], optimizer.de.population: 20, optimizer.ga.population: [40, 60]}]"],
         [("de", 20), ("ga", 40), ("ga", 60)]),
        # the command line says more than the grid
        (["grid=[{optimizer: [de, ga], optimizer.de.population: 20}]", "optimizer.population=60"], [("de", 60), ("ga", 60)]),
        (["grid=[{optimizer: [de, ga], optimizer.population: [40, 60]}]", "optimizer.de.population=20"],
         [("de", 20), ("ga", 40), ("ga", 60)]),
        (["grid=[{optimizer: [de, lm], optimizer.de.population: 20}]", "optimizer=lm"], [("lm", None)]),
        (["grid=[{optimizer: [de, ga]}]", "+standard={optimizer.de.population: 20, optimizer.population: 30}"],
         [("de", 20), ("ga", 30)]),
    ],
)  # fmt: skip
def test_a_setting_that_names_its_plugin_is_for_that_one_alone(words, expected, compose):
    plan = compose("method=direct", *words)
    assert populations(plan) == expected
    assert not any("optimizer.de.population" in cell.place for cell in plan.cells)  # one column for all that have it


@pytest.mark.parametrize(
    "words, line",
    [
        (["optimizer.lmm.screening=5"], "unknown setting 'optimizer.lmm'; did you mean 'optimizer.lm'"),
        (["optimizer.lm.screenin=5"], "unknown setting 'optimizer.lm.screenin'; did you mean 'optimizer.lm.screening'"),
        (
            ["optimizer.pso.population=5"],
            "optimizer.pso.population: expected a setting of what is chosen, optimizer=de,lm",
        ),
        (["grid=[{optimizer.de.popul: 5}]"], "unknown setting 'optimizer.de.popul'; did you mean"),
    ],
)
def test_a_plugin_that_is_not_there_or_not_chosen_is_named(words, line, compose):
    with pytest.raises(SettingError, match=line):
        compose("method=direct", "optimizer=de,lm", *words)


def test_table3_is_planned_as_the_paper_has_it(compose):
    plan = compose("+experiment=table3")
    assert (plan.name, plan.report.paper, plan.axes) == ("table3", "table3", ("samples",))
    assert [cell.settings["samples"] for cell in plan.cells] == [40, 70, 100, 200]
    assert len(plan.runs) == 4 * 20
    names = {part: settings["name"] for part, settings in plan.cells[0].settings.items() if part in registry.GROUPS}
    assert names == {
        "problem": "three_disk",
        "measurement": "synthetic",
        "surrogate": "kriging",
        "optimizer": "de",
        "method": "ksmea",
        "study": "identify",
    }
    assert plan.cells[0].settings["problem"]["mesh"] == 13
    assert plan.cells[0].settings["measurement"]["relative"] == 0.1


def test_repetitions_come_one_after_the_other_over_all_cells(compose):
    plan = compose("+experiment=table3", "repetitions=3")
    assert [(run.repetition, run.cell) for run in plan.runs] == [(r, c) for r in range(3) for c in range(4)]


def test_what_the_method_ignores_does_not_tell_runs_apart(compose):
    plan = compose("method=direct", "samples=40,70", "surrogate=kriging,rsm", "repetitions=1")
    assert len({run.key for run in plan.runs}) == 1
    assert [cell.place["samples"] for cell in plan.cells] == [40, 70]  # a row of the table each
    assert [cell.place["surrogate"] for cell in plan.cells] == [None, None]  # which counts once


def test_the_key_does_not_depend_on_the_order_of_settings(compose):
    plan = compose("+experiment=table3", "repetitions=2")
    turned = tuple(dataclasses.replace(cell, settings=_reversed(cell.settings)) for cell in plan.cells)
    assert list(turned[0].settings) != list(plan.cells[0].settings)
    versions = _reversed(plan.versions)
    assert all_runs(turned, 2, versions) == plan.runs


def _reversed(settings):
    return {
        key: _reversed(value) if isinstance(value, dict) else value for key, value in reversed(list(settings.items()))
    }


def test_a_repetition_has_the_same_seeds_for_all_methods_and_samples(compose):
    plan = compose("samples=40,70", "surrogate=kriging,rsm", "optimizer=de,pso", "repetitions=2", "seed=7")
    for repetition in range(2):
        seeds = [plan.seeds(run) for run in plan.runs if run.repetition == repetition]
        assert len(seeds) == 8 and all(each == seeds[0] for each in seeds)


@pytest.mark.slow
def test_cells_with_seeds_of_their_own_draw_other_numbers_and_keep_them_among_others(compose):
    runout = "measurement.hidden=[runout]"  # which is drawn faster than others
    words = ["+experiment=diagnosis_effects", "repetitions=1", runout]
    effects = compose(*words)
    seeds = {cell.place["label"]: cell.seed for cell in effects.cells}
    assert len(set(seeds.values())) == len(seeds) == 25
    assert {cell.seed for cell in compose("+experiment=table3", "repetitions=1").cells} == {0}
    other = compose(*words, "seed=1", "problem.mesh=13,14")
    assert not {cell.seed for cell in other.cells} & set(seeds.values())
    assert len({cell.seed for cell in other.cells}) == 25 and len(other.cells) == 50  # compared on the same noise


def test_components_repetitions_and_seeds_draw_different_numbers():
    drawn = [
        generator(entropy).random()
        for seed in range(3)
        for repetition in range(4)
        for entropy in component_seeds(seed, repetition).values()
    ]
    assert sorted(component_seeds(0, 0)) == sorted(COMPONENTS)
    assert len(set(drawn)) == len(drawn) == 3 * 4 * len(COMPONENTS)


def test_the_same_seeds_draw_the_same_numbers_for_ever():
    """Written down, so that a change of the seeding cannot pass unseen: it would change every table."""
    first = [generator(component_seeds(0, 1)[component]).integers(1_000_000) for component in COMPONENTS]
    expected = [np.random.default_rng([0, 1, place]).integers(1_000_000) for place in (1, 2, 3, 4, 5, 6)]
    assert first == expected


def test_the_file_gives_back_the_plan(compose, tmp_path):
    plan = compose("+experiment=table3", "optimizer=de,ga", "problem.limits.kxx=[10,90]", "repetitions=2", "seed=3")
    write_plan(plan, tmp_path / "new" / "folder")
    assert read_plan(tmp_path / "new" / "folder") == plan
    assert [path.name for path in (tmp_path / "new" / "folder").iterdir()] == ["plan.jsonl"]


def test_another_plan_replaces_the_file(compose, tmp_path):
    write_plan(compose("+experiment=table3"), tmp_path)
    smaller = compose("repetitions=1")
    write_plan(smaller, tmp_path)
    assert read_plan(tmp_path) == smaller


def test_no_plan_or_one_of_another_schema_is_refused_in_one_line(compose, tmp_path):
    with pytest.raises(SettingError, match=r"found no plan\.jsonl; run the experiment first$"):
        read_plan(tmp_path)
    write_plan(compose("repetitions=1"), tmp_path)
    file = tmp_path / "plan.jsonl"
    head, *rest = file.read_text().splitlines()
    file.write_text("\n".join([json.dumps({**json.loads(head), "schema": 0}), *rest]))
    with pytest.raises(SettingError, match=r"expected a plan of schema") as caught:
        read_plan(tmp_path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "words, standard",
    [
        (["method=ksmea,direct", "problem.mesh=13,21"], []),
        (
            ["+experiment=contest", "label=Kriging + EI", "problem.instance=0,1", "problem.family=one_disk"],
            ["method.polish=false"],
        ),
        (["name=${hydra.job.config_name}", "optimizer.population=20,30"], []),
        (["name='${ hydra.job.config_name}'", "optimizer.population=20,30"], []),
        (["name='${oc.select:hydra.job.config_name}'", "optimizer.population=20,30"], []),
    ],
    ids=["sweep", "settings that take others' values", "a setting of Hydra", "with a space", "by a resolver"],
)
def test_a_cell_is_what_hydra_composes_of_its_point(compose, loader, words, standard):
    """Points are copies of configurations that are composed once for each choice of plugins. Here all of a point is composed for
    itself; `standard` is what the experiment sets of the plugins chosen."""
    plan = compose(*words)
    fixed = [word for word in words if "," not in word]
    for cell in plan.cells[-2:]:
        point = {key: value for key, value in cell.place.items() if value is not None}
        plugins_first = sorted(point, key=lambda key: key not in registry.GROUPS)
        of_point = [override(key, point[key]) for key in plugins_first]
        own = loader.load_configuration("config", [*fixed, *of_point, *standard], RunMode.RUN)
        assert plan.name == own.name
        for group in registry.GROUPS:
            if cell.settings[group] is not None:
                assert cell.settings[group] == OmegaConf.to_container(own[group], resolve=True)


def test_cells_of_equal_problem_and_noise_share_their_crlb(compose, monkeypatch):
    asked = []
    crlb = Setup.crlb
    monkeypatch.setattr(Setup, "crlb", lambda setup: asked.append(setup) or crlb(setup))
    plan = compose("optimizer=de,lm", "measurement.relative=0.05,0.1", "problem.mesh=13,14")
    assert (len(plan.cells), len(asked)) == (8, 4)
    for cell in plan.cells:
        assert [facts.crlb for facts in cell.parameters] == crlb(Setup.of(cell.settings))
