"""Wrong command lines as people type them: each is refused in one line that names what is wrong, most with the line that was
meant. None reaches a plugin: a look at the words is enough."""

import shlex
import subprocess
import sys

import pytest

from bench.command_line.corrected_command import corrected
from bench.command_line.quick_check import _require_files, looked_at
from bench.commands.dispatch import COMMANDS
from ksmea.errors import SettingError

LIST = "expected a list [a,b,...]"
# What is typed, what the one line has to contain, and what was meant ("" where nobody can tell).
NO_SETTING = [
    ("table3", "an experiment is chosen by +experiment=table3", "+experiment=table3"),
    ("tabel3", "did you mean the experiment 'table3'?", "+experiment=table3"),
    ("Table3", "did you mean the experiment 'table3'?", "+experiment=table3"),
    ("run table3", "an experiment is chosen by +experiment=table3", "+experiment=table3"),
    ("+table3 seed=1", "an experiment is chosen by", "+experiment=table3 seed=1"),
    ("statsu table3", "unknown command 'statsu'; did you mean 'status'?", "status table3"),
    ("Status table3", "unknown command 'Status'; did you mean 'status'?", "status table3"),
    ("+experiment=table3 status", "expected a command as the first word", "status +experiment=table3"),
    ("experiments", "python -m bench help lists all", ""),
    ("samples", "expected setting=value, got no value", ""),
    ("samples 40", "in one word, without spaces", "samples=40"),
    ("samples = 40", "in one word, without spaces", "samples=40"),
    ("samples =40", "in one word, without spaces", "samples=40"),
    ("samples:40", "got a colon", "samples=40"),
    ("optimizer:de", "got a colon", "optimizer=de"),
    ("=40", "got no name of a setting", ""),
    ("samples==40", "expected one '=', got two", "samples=40"),
    ("~optimizer", "a setting cannot be taken away", ""),
    ("seed=1 ~samples", "a setting cannot be taken away", "seed=1"),
]
OPTIONS = [
    ("--samples=40", "settings stand without dashes", "samples=40"),
    ("--samples 40 seed=1", "settings stand without dashes", "samples=40 seed=1"),
    ("--experiment table3", "settings stand without dashes", "+experiment=table3"),
    ("--experiment=table3", "settings stand without dashes", "+experiment=table3"),
    ("--multrun", "unknown option '--multrun'; did you mean '--multirun'?", "--multirun"),
    ("-x", "unknown option '-x'", ""),
    ("--cfg", "--cfg: expected one of all, hydra, job after it, got nothing", ""),
    ("--cfg jobs", "unknown value of --cfg: 'jobs'; did you mean 'job'?", "--cfg job"),
    ("--config-dir", "--config-dir: expected a value after it", ""),
]
SHAPE = [
    ("optimizer=de pso", "several values have commas between them", "optimizer=de,pso"),
    ("optimizer=de, pso", "expected no space after a comma", "optimizer=de,pso"),
    ("optimizer=de,", "on both sides of each comma", "optimizer=de"),
    ("samples=40,,70", "on both sides of each comma", "samples=40,70"),
    ("'samples=40;70'", "expected commas between values, got a semicolon", "'samples=40,70'"),
    ("problem.sensors=[0.1", "expected ] at the end", "'problem.sensors=[0.1]'"),
    ("problem.sensors=0.1]", "a closing one that none opens", ""),
    ('"output=\'x"', "expected ' at the end", "\"output='x'\""),
    ("add=[{label: Mine, optimizer: lm}]", "the whole value in one word", "'add=[{label: Mine, optimizer: lm}]'"),
    ("add={label: Mine, optimizer: lm}", "the whole value in one word", "'add=[{label: Mine, optimizer: lm}]'"),
    ("problem.sensors=[0.1, 0.5] seed=1", "the whole value in one word", "'problem.sensors=[0.1, 0.5]' seed=1"),
]
NAMES = [
    ("+experiment=Table3", "unknown experiment 'Table3'; did you mean 'table3'?", "+experiment=table3"),
    ("experiment=tabel3", "unknown experiment 'tabel3'; did you mean 'table3'?", "experiment=table3"),
    ("+experiment=", "experiment: expected one of audit, balance", ""),
    ("+experiment=null", "unknown experiment 'null'", None),
    ("optimizer=DE", "unknown optimizer 'DE'; did you mean 'de'?", "optimizer=de"),
    ("optimizer=de,psso", "unknown optimizer 'psso'; did you mean 'pso'?", "optimizer=de,pso"),
    ("optimizer=", "optimizer: expected one of chain, cmaes, de", ""),
    ("problem=my_rotor.yaml", "unknown problem 'my_rotor.yaml'", "problem=rotor problem.file=my_rotor.yaml"),
    ("measurement=run.csv", "unknown measurement 'run.csv'", "measurement=file measurement.path=run.csv"),
    ("Optimizer=de", "unknown setting 'Optimizer'; did you mean 'optimizer'?", "optimizer=de"),
    ("repetitons=3", "unknown setting 'repetitons'; did you mean 'repetitions'?", "repetitions=3"),
    ("+foo=1", "unknown setting 'foo'", None),
    ("problm.mesh=3", "unknown group 'problm'; did you mean 'problem'?", None),
    ("optimizer.populaton=3", "did you mean 'optimizer.population'?", "optimizer.population=3"),
    (
        "+experiment=table3 optimizer.Population=3",
        "'optimizer.population'?",
        "+experiment=table3 optimizer.population=3",
    ),
    ("optimizer=de,lm optimizer.screning=3", "'optimizer.screening'?", "optimizer=de,lm optimizer.screening=3"),
    ("optimizer=de,ga optimizer.inertia=3", "optimizer=pso has it", "optimizer.inertia=3 optimizer=de,ga,pso"),
    ("optimizer.inertia=3", "optimizer=pso has it", "optimizer.inertia=3 optimizer=pso"),
    ("measurement.path=run.csv", "measurement=campaign and measurement=file have it", ""),
    (
        "optimizer=de,pso optimizer.pso.inertai=3",
        "'optimizer.pso.inertia'?",
        "optimizer=de,pso optimizer.pso.inertia=3",
    ),
    ("method.misfit=Log", "did you mean 'log'?", "method.misfit=log"),
    ("hydra/sweeper=basic", "hydra/sweeper: expected plan", ""),
    ("hydra.mode=RUN", "hydra.mode: expected MULTIRUN", ""),
]
VALUES = [
    ("samples=abc", "samples: expected a whole number, got 'abc'", ""),
    ("samples=", "samples: expected a whole number, got nothing", ""),
    ("samples=40-70", "samples: expected a whole number, got '40-70'", ""),
    ("samples=1e2", "samples: expected a whole number, got '1e2'", ""),
    ("samples=[40,70]", "several values are written without brackets", "samples=40,70"),
    ("workers=all", "workers: expected a whole number, got 'all'", ""),
    ("timeout=10s", "timeout: expected a number, got '10s'", ""),
    ("memory=4GB", "memory: expected a number, got '4GB'", ""),
    ("journal=maybe", "journal: expected true or false, got 'maybe'", ""),
    ("measurement.relative=5%", "measurement.relative: expected a number, got '5%'", ""),
    ("measurement.relative=0,05", "expected a decimal point", "measurement.relative=0.05"),
    ("optimizer=de,lm optimizer.screening=many", "optimizer.screening: expected a whole number, got 'many'", ""),
    ("name=", "name: expected the name of a file, got nothing", ""),
    ("output=", "output: expected a folder, output=. for the working directory, got nothing", ""),
    ("label=", "label: expected a label, got nothing", ""),
    ("label=[]", "label: expected a label, got a list", ""),
    ("label=null", "label: expected a label, got null", ""),
    ("figures=trace", f"figures: {LIST}, got one value", "'figures=[trace]'"),
    ("includes=table3", f"includes: {LIST}, got one value", "'includes=[table3]'"),
    ("plugins=my.py", f"plugins: {LIST}, got one value", "'plugins=[my.py]'"),
    ("problem.sensors=0.1,0.5", f"problem.sensors: {LIST}, got one value", "'problem.sensors=[0.1,0.5]'"),
    ("'problem.sensors=(0.1)'", f"problem.sensors: {LIST}, got other brackets", "'problem.sensors=[0.1]'"),
    ("'grid={optimizer:de}'", "[{setting: value, ...}, ...], got one block", "'grid=[{optimizer:de}]'"),
    ("'cross={samples: 40}'", "[{setting: value, ...}, ...], got one block", "'cross=[{samples: 40}]'"),
    ("grid=[de]", "got a list of something else", ""),
    ("standard=[1]", "standard: expected {name: value, ...}, got a list", ""),
]
WRONG = [*NO_SETTING, *OPTIONS, *SHAPE, *NAMES, *VALUES]


@pytest.mark.parametrize("typed, expected, meant", WRONG, ids=[typed for typed, *_ in WRONG])
def test_it_is_refused_with_what_was_meant(typed, expected, meant):
    words = shlex.split(typed)
    with pytest.raises(SettingError) as caught:
        looked_at(words, [*COMMANDS, "help"])
    assert expected in str(caught.value) and "\n" not in str(caught.value)
    if meant is not None:
        assert (corrected(caught.value, words) or []) == shlex.split(meant)


@pytest.mark.parametrize("typed, meant", [(typed, meant) for typed, _, meant in WRONG if meant])
def test_what_was_meant_is_not_refused_for_the_same_reason(typed, meant, tmp_path, monkeypatch):
    words = shlex.split(meant)
    monkeypatch.chdir(tmp_path)
    for name in ("run.csv", "my_rotor.yaml"):
        (tmp_path / name).touch()
    if words[0] in COMMANDS:
        return
    try:
        looked_at(words, COMMANDS)
    except SettingError as error:
        with pytest.raises(SettingError) as caught:
            looked_at(shlex.split(typed), COMMANDS)
        assert str(error) != str(caught.value)
        assert corrected(error, words), "one further step, and that is told too"


@pytest.mark.parametrize(
    "typed",
    [
        "samples=40,70 optimizer=de,pso",
        "samples=range(40,201,40) optimizer=glob(*)",
        "--multirun +experiment=table3",
        "--config-dir mine +experiment=own optimizer=mine optimizer.depth=3",
        "plugins=[my.py] optimizer=mine optimizer.depth=3",
        "+experiment=contest 'label=Kriging + DE'",
        "problem.limits.kxx=[1,2] hydra.job.name=x hydra/launcher=basic",
        "'grid=[{label: A, samples: [40, 70]}, {label: B}]' workers=null timeout=2.5 journal=yes",
        "measurement.relative=0,0.05 seed=13,0",
        "'output=µ=2, a' 'measurement.truth={kxx: 3}' +measurement.mesh=26",
        "optimizer=de,ga optimizer.de.population=20 optimizer.crossover_rate=0.5",
    ],
)
def test_what_is_right_goes_through_as_it_is(typed):
    expected = shlex.split(
        typed.replace("--config-dir mine", "--config-dir=mine")
    )  # an option and its value are joined
    assert looked_at(shlex.split(typed), COMMANDS) == expected


@pytest.mark.parametrize(
    "typed, expected",
    [
        ("+experiment=contest label=lm", "unknown label 'lm'; did you mean 'LM'?"),
        ("'output=a,b'", "try: bench 'output=\"a,b\"'"),
        ("+experiment=paper includes=[tabel2]", "try: bench +experiment=paper 'includes=[table2]'"),
        ("verify table3 worker=2", "try: bench verify table3 workers=2"),
        ("status", "expected one name or folder of results, got none; there are: none below results/ here"),
        ("-q -v help", "got both"),
        ("help tabel3", "unknown name 'tabel3'; did you mean 'table3'?"),
        ("completion fish", "unknown shell 'fish'"),
    ],
)
def test_main_ends_the_line_with_a_command_to_paste(typed, expected, enter):
    ended = enter(*shlex.split(typed))
    assert (ended.code, ended.out) == (2, "") and expected in ended.err
    assert ended.err.count("\n") == 1


def test_a_wrong_name_in_includes_names_its_file(enter, tmp_path):
    (tmp_path / "experiment").mkdir()
    (tmp_path / "experiment" / "mine.yaml").write_text("# @package _global_\nname: mine\nincludes: [table2, tabel3]\n")
    ended = enter("--config-dir", str(tmp_path), "+experiment=mine")
    assert ended.code == 2 and f"{tmp_path / 'experiment' / 'mine.yaml'}: unknown experiment 'tabel3'" in ended.err


@pytest.mark.parametrize(
    "words, said",
    [
        (["+experiment=tabel3"], "did you mean 'table3'"),
        (["+experiment=identify", "problem=rotor", "problem.file=none.yaml"], "problem=rotor: none.yaml: expected a YAML file, found none"),
        (["+experiment=diagnose", "measurement.path=none.csv"], "measurement=file: none.csv: expected a CSV file, found none"),
    ],
)  # fmt: skip
def test_refusing_a_name_or_file_loads_nothing_large(words, said, tmp_path):
    code = (
        f"import sys; from bench import main; main.run({words}); main.run(['help']);"
        " print([name for name in ('numpy', 'hydra', 'yaml', 'scipy') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout.splitlines()[-1] == "[]" and said in done.stderr


@pytest.mark.parametrize(
    "typed",
    [
        "measurement=file measurement.path=runs/*.csv",  # a fleet
        "measurement=synthetic,file measurement.path=none.csv",
        "measurement=mine measurement.path=tcp://rig",
        "measurement=file measurement.path=null",
    ],
)
def test_paths_that_no_listing_decides_are_left_to_the_plugins(typed):
    _require_files(dict(word.split("=", 1) for word in typed.split()))
