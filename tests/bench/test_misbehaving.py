"""Plugins that change, break or end their process, beside a healthy one: its numbers stay equal to the last digit, and the reason of each
failure is one line."""

import json
import os

import pytest

from misbehaving_plugins import AT_IMPORT, IN_SETTINGS, WHILE_IT_RUNS, source
from tiers import mostly_slow

FAST = ["repetitions=2", "workers=2"]
FEW_POINTS = ["optimizer=random_search", "optimizer.evaluations=100"]
COMMANDS = {  # the healthy plugin of each kind, and settings of a fast run
    "optimizer": ("random_search", ["method=direct"]),
    "surrogate": ("rsm", ["samples=25", "method.max_updates=1", "optimizer.generations=1", "optimizer.population=6"]),
    "problem": ("three_disk", ["method=direct", *FEW_POINTS]),
    "measurement": ("synthetic", ["method=direct", *FEW_POINTS]),
    "method": ("direct", FEW_POINTS),
}
ALL = list(WHILE_IT_RUNS)
DONE = {
    "optimizer": ALL,
    "surrogate": ALL[:6],
    "problem": [*ALL[:2], ALL[3], *ALL[9:13]],
    "measurement": ALL[6:12],
    "method": ALL[10:],
}


def run(apart, folder, kind, plugins):
    """The healthy plugin of a kind and these files beside it in one command; all that it found by the plugin's name."""
    healthy, words = COMMANDS[kind]
    for name, text in plugins.items():
        (folder / f"{name}.py").write_text(text)
    files = [f"plugins=[{','.join(f'{name}.py' for name in plugins)}]"] if plugins else []
    chosen = f"{kind}={','.join([healthy, *plugins])}"
    ended = apart(*files, chosen, *words, *FAST, cwd=folder, output="results/run", KSMEA_IMPORT_SECONDS="6")
    assert "Traceback" not in ended.err, ended.err
    return ended, found(ended, kind)


def found(ended, kind):
    lines = [json.loads(line) for line in (ended.output / "plan.jsonl").read_text().splitlines()]
    cells = [line for line in lines if line["line"] == "cell"]
    of_run = {
        line["key"]: (cells[line["cell"]]["settings"][kind]["name"], line["repetition"])
        for line in lines
        if line["line"] == "run"
    }
    return {of_run[line["key"]]: line for line in ended.events()}


@pytest.fixture(scope="module")
def alone(apart, tmp_path_factory):
    """The numbers of the healthy plugin of each kind without any other."""
    kept = {}

    def numbers(kind):
        if kind not in kept:
            kept[kind] = run(apart, tmp_path_factory.mktemp(kind), kind, {})[1]
        return kept[kind]

    return numbers


def assert_unharmed(kind, together, alone):
    healthy = COMMANDS[kind][0]
    for repetition in (0, 1):
        line, expected = together[healthy, repetition], alone(kind)[healthy, repetition]
        assert line["status"] == expected["status"] and line["status"] in ("done", "budget")
        assert line["parameters"] == expected["parameters"] and line["misfit"] == expected["misfit"]


@pytest.mark.parametrize("kind", mostly_slow(COMMANDS, but=["optimizer"]))
def test_whatever_it_does_while_it_runs(kind, apart, alone, tmp_path):
    doing = {name: WHILE_IT_RUNS[name] for name in DONE[kind]}
    plugins = {
        f"bad{number}": source(kind, doing=each, name=f"Bad{number}") for number, (each, _) in enumerate(doing.values())
    }
    _, together = run(apart, tmp_path, kind, plugins)
    assert_unharmed(kind, together, alone)
    for number, (name, (_, has_results)) in enumerate(doing.items()):
        lines = [line for (plugin, _), line in together.items() if plugin == f"bad{number}"]
        reasons = [line["error"] for line in lines if line["status"] not in ("done", "budget")]
        assert all(reason and "\n" not in reason for reason in reasons), name
        if has_results is not None and lines:
            assert bool(reasons) is not has_results, (name, reasons)
    assert not [each for each in processes() if "sleep 300" in each], "what it has started has ended"


def processes():
    for number in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{number}/cmdline") as file:
                yield file.read().replace("\0", " ")
        except OSError:
            continue


@pytest.mark.slow
@pytest.mark.parametrize("kind", mostly_slow(["optimizer", "measurement"], but=["optimizer"]))
def test_whatever_it_does_while_it_is_imported(kind, apart, alone, tmp_path):
    texts = {f"bad{n}": source(kind, at_import=each, name=f"Bad{n}") for n, (each, _) in enumerate(AT_IMPORT.values())}
    ended, together = run(apart, tmp_path, kind, texts)
    assert_unharmed(kind, together, alone)
    left_out = [line for line in ended.out.splitlines() if line.startswith("note: left out: ")]
    for number, (name, (_, reason)) in enumerate(AT_IMPORT.items()):
        lines = [line for line in left_out if f"bad{number}.py" in line]
        assert len(lines) == bool(reason) and all(reason in line for line in lines), (name, lines)
        assert ((f"bad{number}", 0) in together) is (not reason), name
    assert ended.code == 1


@pytest.mark.slow
def test_whatever_its_settings_are(apart, alone, tmp_path):
    texts = {
        f"bad{n}": source("optimizer", settings=each, name=f"Bad{n}")
        for n, (each, _) in enumerate(IN_SETTINGS.values())
    }
    ended, together = run(apart, tmp_path, "optimizer", texts)
    assert_unharmed("optimizer", together, alone)
    for number, (name, (_, reason)) in enumerate(IN_SETTINGS.items()):
        lines = [
            line
            for line in ended.out.splitlines()
            if line.startswith("note: left out: ") and f"bad{number}" in line.lower()
        ]
        assert len(lines) == 1 and reason in lines[0], (name, lines)
    assert ended.code == 1


def test_processes_that_settings_start_end_with_the_plan(apart, tmp_path):
    """Planned and not run: in the fork that tries the plan first, and in the plan itself."""
    started = "def check(self): subprocess.Popen(['sleep', '299'])"
    (tmp_path / "bad.py").write_text("import subprocess\n" + source("optimizer", settings=started))
    ended = apart("plugins=[bad.py]", "optimizer=bad", "method=direct", "repetitions=0", cwd=tmp_path, output="planned")
    assert "Traceback" not in ended.err, ended.err
    assert not [each for each in processes() if "sleep 299" in each]


@pytest.mark.slow
def test_one_that_is_chosen_alone_is_refused_in_one_line(apart, tmp_path):
    for number, (text, reason) in enumerate((*AT_IMPORT.values(), *IN_SETTINGS.values())):
        if not reason or "hangs" in text or "sleep" in text:
            continue
        at_import, settings = (text, "pass") if number < len(AT_IMPORT) else ("", text)
        (tmp_path / "bad.py").write_text(source("optimizer", at_import=at_import, settings=settings))
        ended = apart("plugins=[bad.py]", "optimizer=bad", "method=direct", "repetitions=1", cwd=tmp_path)
        assert ended.code == 2 and ended.err.count("\n") == 1 and reason in ended.err, ended.err


@pytest.mark.slow
def test_an_effect_that_misbehaves_harms_no_cell_without_it(apart, tmp_path):
    words = ["method=direct", *FEW_POINTS, "measurement.kind=complex", "measurement.relative=0.05", *FAST]
    doing = [each for each, _ in WHILE_IT_RUNS.values()][:5]
    for number, each in enumerate(doing):
        (tmp_path / f"bad{number}.py").write_text(source("effect", doing=each, name=f"Bad{number}"))
    files = f"plugins=[{','.join(f'bad{number}.py' for number in range(5))}]"
    lines = ",".join(f"{{label: bad{number}, measurement.hidden: [[bad{number}]]}}" for number in range(5))
    plain = apart(*words, "grid=[{label: fine}]", "output=plain", cwd=tmp_path, output="plain")
    both = apart(*words, files, f"grid=[{{label: fine}},{lines}]", "output=both", cwd=tmp_path, output="both")
    assert "Traceback" not in both.err, both.err
    expected = {line["key"]: line["parameters"] for line in plain.events()}
    lines = {line["key"]: line for line in both.events()}
    assert len(expected) == 2 and all(lines[key]["parameters"] == values for key, values in expected.items())
    of_effects = [line for key, line in lines.items() if key not in expected]
    left_out = [line for line in both.out.splitlines() if line.startswith("note: left out: effect=bad")]
    assert len(of_effects) == 2 * (len(doing) - len(left_out))
    assert all("expected cells that can be planned, got " in line for line in left_out)
    failed = [line["error"] for line in of_effects if line["status"] not in ("done", "budget")]
    assert failed and all(reason and "\n" not in reason for reason in failed), failed
