"""Bad input is one line that names the offending thing, exit code 2, and nothing written anywhere."""

import pytest

TABLE3 = "+experiment=table3"

# What is typed, and what the one line has to contain.
UNKNOWN = [
    (
        ["optimizer=dee"],
        "unknown optimizer 'dee'; did you mean 'de'? known: chain, cmaes, de, dual_annealing, ga, lm, nelder_mead, pso, random_search",
    ),
    (["optimizer=de,psso"], "unknown optimizer 'psso'; did you mean 'pso'?"),
    (["surrogate=krigng"], "unknown surrogate 'krigng'; did you mean 'kriging'?"),
    (["problem=three_dsk"], "unknown problem 'three_dsk'; did you mean 'three_disk'?"),
    (["measurement=syntetic"], "unknown measurement 'syntetic'; did you mean 'synthetic'?"),
    (["method=ksma"], "unknown method 'ksma'; did you mean 'ksmea'?"),
    (["+experiment=tabel3"], "unknown experiment 'tabel3'; did you mean 'table3'?"),
    (["experiment=xyz"], "unknown experiment 'xyz'; known: "),
    (["optimiser=de"], "unknown setting 'optimiser'; did you mean 'optimizer'?"),
    (["+experimnt=table3"], "unknown setting 'experimnt'; did you mean 'experiment'?"),
    (["repetitons=3"], "unknown setting 'repetitons'; did you mean 'repetitions'?"),
    (["+repetitons=3"], "unknown setting 'repetitons'; did you mean 'repetitions'?"),
    (["optimizer.populaton=30"], "unknown setting 'optimizer.populaton'; did you mean 'optimizer.population'?"),
    (["optimizer.populaton=30,40"], "unknown setting 'optimizer.populaton'; did you mean 'optimizer.population'?"),
    (["+optimizer.populaton=30"], "unknown setting 'optimizer.populaton'; did you mean 'optimizer.population'?"),
    (["optimizer=pso", "optimizer.mutation_factor=1"], "unknown setting 'optimizer.mutation_factor'"),
    (["problem.limits.kxz=[1,2]"], "unknown setting 'problem.limits.kxz'; did you mean 'problem.limits.kxx'?"),
    (["measurement.truth.kyx=3"], "unknown parameter in measurement.truth: 'kyx'; did you mean 'k"),
    (["measurement.kind=amplitud"], "unknown value for kind: 'amplitud'; did you mean 'amplitude'?"),
    (["grid=[{optimizr:de}]"], "unknown setting 'optimizr'; did you mean 'optimizer'?"),
    (["grid=[{optimizer:dee}]"], "unknown optimizer 'dee'; did you mean 'de'?"),
    (["own_seeds=labels"], "unknown value for own_seeds: 'labels'; did you mean 'label'? known: instance, label"),
    (["problem=drawn", "problem.family=rotors"], "unknown value for family: 'rotors'"),
    (["study.budget=0"], "study=identify: budget: expected a number at least 1, got 0"),
    (["cross=3"], "cross: expected a list [a,b,...], got one value"),
    (["paper=table33"], "unknown table of the paper 'table33'; did you mean 'table3'?"),
    (["hydra/launcher=basc"], "unknown hydra/launcher 'basc'; did you mean 'basic'?"),
    (["--multrun"], "unknown option '--multrun'; did you mean '--multirun'?"),
    (["-x"], "unknown option '-x'"),
    ([TABLE3, "-m=30"], "-m=30: expected -m without a value, got one; try: "),
    ([TABLE3, "samples=40", "--nosuch=1"], "unknown option '--nosuch=1'"),
]
WRONG_TYPE = [
    (["samples=many"], "samples: expected a whole number, got 'many'"),
    (["samples=40,many"], "samples: expected a whole number, got 'many'"),
    (["samples=40.5"], "samples: expected a whole number, got '40.5'"),
    (["samples=[40,70]"], "samples: "),
    (["samples=null"], "samples: "),
    (["seed=1.5"], "seed: expected a whole number, got '1.5'"),
    (["repetitions="], "repetitions: expected a whole number, got nothing"),
    (["optimizer.population=ten"], "optimizer.population: expected a whole number, got 'ten'"),
    (["optimizer.mutation_factor=high"], "optimizer.mutation_factor: expected a number, got 'high'"),
    (["optimizer.mutation_factor=0.5,high"], "optimizer.mutation_factor: expected a number, got 'high'"),
    (["optimizer=chain", "optimizer.then=lmm"], "optimizer=chain: unknown optimizer 'lmm'; did you mean 'lm'?"),
    (
        ["optimizer=chain", "optimizer.first_settings={popul: 3}"],
        "optimizer=chain: unknown setting of optimizer=de: 'popul'",
    ),
    (["method.polish=maybe"], "method.polish: expected true or false, got 'maybe'"),
    (["problem.sensors=0.1"], "problem.sensors: expected a list [a,b,...], got one value"),
    (["problem.sensors=[here]"], "problem.sensors[0]: expected a number, got 'here'"),
    (["problem.limits=3"], "problem.limits: "),
    (["problem.limits.kxx=3"], "problem.limits.kxx: expected a list [a,b,...], got one value"),
    (["measurement.truth.kxx=stiff"], "measurement.truth.kxx: expected a number, got 'stiff'"),
    (
        ["optimizer=3"],
        "unknown optimizer '3'; known: chain, cmaes, de, dual_annealing, ga, lm, nelder_mead, pso, random_search",
    ),
    (
        ["optimizer=null"],
        "unknown optimizer 'None'; known: chain, cmaes, de, dual_annealing, ga, lm, nelder_mead, pso, random_search",
    ),
    (["optimizer=[de,pso]"], "unknown optimizer '['de', 'pso']'"),
    (["output=[a,b]"], "output: "),
    (["timeout=soon"], "timeout: expected a number, got 'soon'"),
    (["grid=3"], "grid: expected a list [a,b,...], got one value"),
]
OUT_OF_RANGE = [
    (["samples=0"], "samples: expected a number at least 1, got 0"),
    (["samples=40,-1"], "samples: expected a number at least 1, got -1"),
    (["samples=2"], "for this surrogate with 5 unknowns, got 2; take more samples, or a lower trend or degree"),
    (
        ["surrogate.trend=quadratic", "samples=40,21"],
        "samples: expected at least 22 for this surrogate with 5 unknowns",
    ),
    (["surrogate=rsm", "surrogate.degree=3", "samples=40"], "samples: expected at least 57 for this surrogate"),
    (["method.budget=30", "samples=40"], "method.budget: expected more than the 40 initial samples, got 30"),
    (["measurement.relative=-0.1"], "measurement=synthetic: relative: expected a number at least 0, got -0.1"),
    (["measurement.relative=0.1,-0.1"], "measurement=synthetic: relative: expected a number at least 0, got -0.1"),
    (["measurement.floor=-1"], "measurement=synthetic: floor: expected a number at least 0, got -1"),
    (["problem.mesh=3"], "problem=three_disk: mesh: expected at least 4 elements, got 3"),
    (["problem.mesh=13,0"], "problem=three_disk: mesh: expected at least 4 elements, got 0"),
    (["measurement.mesh=3"], "measurement.mesh: expected at least 4 elements, got 3"),
    (["problem.limits.kxx=[100,10]"], "problem=three_disk: limits of kxx: expected lower < upper, got [100, 10] MN/m"),
    (["problem.limits={u:[5]}"], "problem=three_disk: limits of u: expected [lower, upper] in g mm, got [5.0]"),
    (["problem.speed_from=1600"], "problem=three_disk: speed_to: expected more than speed_from (1600), got 1500"),
    (["problem.sensors=[]"], "problem=three_disk: sensors: expected at least one entry"),
    (["problem.directions=[z]"], "problem=three_disk: directions: expected x, y or degrees from x towards y, got 'z'"),
    (["optimizer.mutation_factor=nan"], "optimizer=de: mutation_factor: expected a number above 0"),
    (["optimizer.population=4"], "optimizer=de: population: expected a number at least 5, got 4"),
    (["optimizer=ga", "optimizer.bits=[10,10]"], "optimizer=ga: bits: expected a sum of chromosome_length = 52, got"),
    (["optimizer=ga", "optimizer.bits=[26,26]"], "bits: expected one entry for each of 5 parameters, got 2 entries"),
    (["repetitions=0"], "repetitions: expected a number at least 1, got 0"),
    (["workers=0"], "workers: expected a number at least 1, got 0"),
    (["batches=0"], "batches: expected a number at least 1, got 0"),
    (["timeout=0"], "timeout: expected a number above 0, got 0"),
    (["seed=-1"], "seed: expected a number at least 0, got -1"),
    (["seed=1,-1"], "seed: expected a number at least 0, got -1"),
    (["name=a/b"], "name: expected the name of a file, got 'a/b'"),
]
GRAMMAR = [
    (["problem.sensors=[0.1"], "problem.sensors=[0.1: expected ] at the end"),
    (["samples=40,,70"], "samples=40,,70: expected a value on both sides of each comma"),
    (["output='x"], "output='x: expected ' at the end"),
    (["table3"], "table3: expected setting=value"),
    (
        ["samples=interval(40,70)"],
        "samples: expected a value, a list a,b,c or range(from,to,step), got interval(40,70), which has no steps",
    ),
    (["output=a,b"], "output: expected one value for the whole experiment, got several"),
    (["repetitions=1,2"], "repetitions: expected one value for the whole experiment, got several"),
    (["+experiment=table3,table3"], "experiment: expected one value for the whole experiment, got several"),
    (["workers=1,2"], "workers: expected one value for the whole experiment, got several"),
    (["grid=[{repetitions:[1,2]}]"], "repetitions: expected one value for the whole experiment, got several"),
]


BAD = [*UNKNOWN, *WRONG_TYPE, *OUT_OF_RANGE, *GRAMMAR]


@pytest.fixture
def refuse(enter, monkeypatch):
    """The bench without its work: what it should refuse, and does not, ends the test at once."""

    def work(job):
        raise AssertionError("bad input was worked on")

    monkeypatch.setattr("bench.run_experiment.work", work)
    return enter


def assert_refused(ended, expected, folder):
    assert ended.code == 2
    assert ended.out == ""
    [line] = ended.err.splitlines()
    assert line.startswith("error: ") and expected in line
    assert "Traceback" not in ended.err
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("words, expected", BAD, ids=[" ".join(words) for words, _ in BAD])
def test_bad_input_is_one_line(words, expected, refuse, tmp_path):
    assert_refused(refuse(*words), expected, tmp_path)


@pytest.mark.parametrize(
    "words, expected",
    [
        ([TABLE3, "optimizer=psoo"], "unknown optimizer 'psoo'; did you mean 'pso'?"),
        ([TABLE3, "samples=0"], "samples: expected a number at least 1, got 0"),
        ([TABLE3, "problem.sensors=[0.1"], "problem.sensors=[0.1: expected ] at the end"),
    ],
)
def test_bad_input_in_a_process_of_its_own(words, expected, shell, tmp_path):
    assert_refused(shell(*words, cwd=tmp_path), expected, tmp_path)


@pytest.mark.parametrize("words", [["optimizer=dee"], ["samples=0"], ["-x"], ["problem.mesh=two"]])
def test_a_variable_of_the_environment_shows_the_traceback(words, refuse, monkeypatch, tmp_path):
    monkeypatch.setenv("BENCH_TRACEBACK", "1")
    ended = refuse(*words)
    assert ended.code == 2 and "Traceback (most recent call last)" in ended.err
    assert ended.err.splitlines()[-1].startswith("error: ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("output", ["taken", "taken/below", "/proc/nowhere"])
def test_an_output_that_cannot_be_written_is_one_line(output, enter, cheapest, tmp_path):
    (tmp_path / "taken").write_text("a file of the user")
    ended = enter(*cheapest, "repetitions=1", f"output={output}")
    assert ended.code == 2 and ended.out == ""
    [line] = ended.err.splitlines()
    assert line.startswith("error: ") and output.split("/")[-1] in line and "output=DIR" in line
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("taken", "a file of the user")]


def test_bad_input_after_good_results_leaves_them_alone(enter, cheapest, tmp_path):
    enter(*cheapest, "repetitions=1")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert enter(*cheapest, "repetitions=0").code == 2
    assert enter(*cheapest, "problem.mesh=13,3").code == 2
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
