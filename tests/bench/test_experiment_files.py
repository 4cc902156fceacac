"""Experiment files of one's own: whatever is wrong in one is one line with its name and the place, never a traceback."""

import os
import time

import pytest

from mutated_experiments import HEALTHY, mutated

HEAD = "# @package _global_\n"
PLAN = ["--config-dir", "conf", "+experiment=mine", "table=settings", "repetitions=0", "output=planned"]
N_MUTATED = int(os.environ.get("KSMEA_MUTATED", "75"))

WRONG = {  # what the file holds, and what the line says behind the file's name
    "name: mine\nname: other": " line 3: expected YAML, got the key 'name' a second time",
    "grid:\n  - {method: direct, optimizer: lm, optimizer: de}": " line 3: expected YAML, got the key 'optimizer' a second time",
    "output: ${nowhere}": ": output: expected ${…} that leads to a setting or a variable (${oc.env:NAME}), got one that does not",
    "output: a${name": ": output: expected ${setting} with both brackets, got 'a${name'",
    "name: ${": ": name: expected ${setting} with both brackets, got '${'",
    "name: ${name}": ": name: expected ${…} that leads to a setting",
    "name: ${oc.env:NO_SUCH}": ": name: expected ${…} that leads to a setting",
    "name: '???'": ": name: expected a value, got ???",
    "name: ": ": name: Incompatible value 'None'",
    "name: ..": ": name: expected the name of a file, got '..'",
    "output: ''": ": output: expected a folder, output=. for the working directory, got nothing",
    "measurement: [1, 2]": ": measurement: expected {setting: value, ...}, got a list; choose a plugin in the file's defaults",
    "optimizer: {name: pso}": ": optimizer: expected settings of a plugin, got its name; choose a plugin in the file's defaults",
    "study: null": ": study: expected {setting: value, ...}, got nothing",
    "standard: [1, 2]": ": standard: expected {name: value, ...}, got a list",
    "standard: {optimizer.population: many}": ": optimizer.population: expected a whole number, got 'many'",
    "problem: {limits: {kxx: [100, 10]}}": ": problem=three_disk: limits of kxx",
    "includes: [table3, [a]]": ": includes[1]: expected a text, got a list",
    "grid: null": ": grid: expected a list of lines {setting: value, ...}, got nothing",
    "grid:\n  - null": ": grid[0]: expected {setting: value, ...}, got nothing",
    "grid:\n  - {samples: 40}\n  - [1]": ": grid[1]: expected {setting: value, ...}, got a list",
    "grid:\n  - {optimizer: [de, null]}": ": grid[0].optimizer: expected names of plugins, got nothing",
    "grid:\n  - {optimizer: [[de]]}": ": grid[0].optimizer: expected names of plugins, got a list",
    "cross:\n  - {samples: []}": ": cross[0].samples: expected at least one value, got an empty list",
    "grid:\n  - {3: 4}": ": expected names of settings before the colons in grid[0], got 3",
    "null: 4": ": expected names of settings before the colons, got None",
    "_target_: os.system": ": unknown setting '_target_'",
    "hydra: {launcher: {_target_: os.nope}}": ": expected settings that Hydra takes, got RuntimeError: Invalid plugin 'os.nope'",
    "defaults: 3": ": defaults: expected a list, '- override /optimizer: pso', got 3",
    "defaults:\n  - override /optimizer: null": ": defaults[0]: expected '- override /optimizer: pso', got override /optimizer: nothing",
    "defaults:\n  - /optimizer: pso": ": defaults[0]: expected 'override /optimizer: pso', got '/optimizer: pso'",
    "defaults:\n  - override /optimizer: psso": ": unknown optimizer 'psso'; did you mean 'pso'?",
    "defaults:\n  - mine": ": expected defaults that end, got a file that includes itself",
    "name: &a [*a]": ": expected values that end, got an alias (*name) of what it stands in",
    "a: &a [1]\n"
    + "".join(
        f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]\n" for a, b in zip("abcdefgh", "bcdefghi")
    ): ": expected at most",
    f"name: {'[' * 3000}": " line 2: expected YAML, got lists nested too deeply",
    "name: !!python/name:os.system": " line 2: expected YAML, got could not determine a constructor",
    'name: "\\ud800"': ": name: expected characters, got half of one in",
    "grid:\n" + "  - {samples: 40}\n" * 20000: ": expected at most 200000 bytes, got",
    "# @package other\nname: mine": ": expected '# @package _global_' once, got _global_, other",
}


@pytest.fixture
def plan(enter, tmp_path):
    """An experiment of one's own is planned and not run."""
    folder = tmp_path / "conf" / "experiment"
    folder.mkdir(parents=True)

    def call(content, words=PLAN):
        (folder / "mine.yaml").write_bytes(content)
        return enter(*words, output="planned")

    return call


def test_the_healthy_file_is_an_experiment(plan):
    ended = plan(HEALTHY.encode())
    assert (ended.code, ended.err) == (0, "") and {cell["place"]["label"] for cell in ended.cells()} == {"DE", "PSO"}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_in_a_file_is_one_line_with_its_name_and_the_place(text, plan):
    ended = plan((HEAD + text + "\n").encode(), [word for word in PLAN if not word.startswith("output")])
    assert ended.code == 2 and ended.err.count("\n") == 1
    assert ended.err.startswith(f"error: conf/experiment/mine.yaml{WRONG[text]}"), ended.err


def test_bytes_that_are_no_text(plan):
    assert (
        "mine.yaml: expected a YAML text in UTF-8, got other bytes at 26"
        in plan((HEAD + "name: ä\n").encode("latin-1")).err
    )


def test_what_words_say_is_not_the_files_fault(enter, plan, tmp_path):
    plan(HEALTHY.encode())
    ended = enter(*PLAN, "optimizer=de", "optimizer.population=many")
    assert ended.code == 2 and "mine.yaml" not in ended.err


def test_a_file_beside_it_that_it_includes(plan, tmp_path):
    (tmp_path / "conf" / "experiment" / "base.yaml").write_text(f"{HEAD}name: a\nname: b\n")
    ended = plan(f"{HEAD}defaults:\n  - base\n".encode())
    assert ended.err.startswith(
        "error: conf/experiment/base.yaml line 3: expected YAML, got the key 'name' a second time"
    )


def test_settings_of_one_line_do_not_reach_the_next(plan):
    """Lines with the same keys share one configuration, into which maps would be merged."""
    sizes = [{"mass_change": 5}, {"youngs_modulus_change": 3}, {"mass_change": 2}]
    effects = [["mass"], ["youngs_modulus"], ["mass"]]
    lines = [
        f"  - {{measurement.hidden: [{hidden}], measurement.sizes: [{size}]}}" for hidden, size in zip(effects, sizes)
    ]
    plain = [f"  - {{label: {label}, measurement.relative: {noise}}}" for label, noise in (("a", 0.1), ("b", 0.2))]
    ended = plan((HEAD + "grid:\n" + "\n".join([*lines, *plain]) + "\n").encode())
    assert ended.code == 0, ended.err
    of_cells = [cell["settings"]["measurement"] for cell in ended.cells()]
    assert [cell["sizes"] for cell in of_cells] == [*sizes, {}, {}]
    assert [cell["relative"] for cell in of_cells[3:]] == [0.1, 0.2]


def test_help_on_such_a_file(enter, plan):
    plan((HEAD + "name: mine\nname: other\n").encode())
    ended = enter("help", "mine", "--config-dir", "conf")
    assert ended.code == 2 and "mine.yaml line 3: expected YAML, got the key 'name'" in ended.err


@pytest.mark.parametrize("block", range(5))
def test_mutated_files(block, plan, tmp_path):
    """Planned, or refused in one line that names the file, unless it is about the folder of the results; never for ever."""
    for seed in range(block * N_MUTATED // 5, (block + 1) * N_MUTATED // 5):
        started = time.monotonic()
        ended = plan(mutated(seed))
        assert ended.code in (0, 2), (seed, ended.err)
        if ended.code == 2:
            assert ended.err.count("\n") == 1 and ended.err[:-1].isprintable(), (seed, ended.err)
            assert "conf/experiment/mine.yaml" in ended.err or "expected a folder of" in ended.err, (seed, ended.err)
        assert time.monotonic() - started < 60, seed
