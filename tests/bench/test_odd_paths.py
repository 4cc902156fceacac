"""Names of folders and files as people have them: umlauts, spaces, µ, '=', commas. Each is typed in the shell's quotes alone."""

import numpy as np
import pytest

import ksmea
from bench.command_line.overrides import parse, with_quoted_files
from measurements.run_up_csv import as_csv

ODD = "Prüfstand 1/µ=2, a"
PLUGIN = '''
from dataclasses import dataclass

from ksmea import Optimizer


@dataclass(frozen=True)
class Middle(Optimizer):
    """Looks at the middle alone."""

    def minimize(self, objective, rng):
        objective(rng.random((3, objective.dim)))
        return objective.result()
'''


@pytest.fixture
def folder(tmp_path):
    (tmp_path / ODD).mkdir(parents=True)
    return tmp_path / ODD


@pytest.mark.slow
def test_a_run_in_such_a_folder_with_such_names(folder, shell, apart):
    """One run in a process that Python starts: working directory, output, plugin and measurement."""
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.5])
    data = ksmea.synthetic_measurement(rotor, relative=0.05, rng=1).measurement
    (folder / "Läufe").mkdir()
    (folder / "Läufe" / "Lauf=1, µ.csv").write_text(as_csv(data), encoding="utf-8")
    (folder / "Läufe" / "middle.py").write_text(PLUGIN, encoding="utf-8")
    done = shell(
        "measurement=file",
        "measurement.path=Läufe/Lauf=1, µ.csv",
        "problem.sensors=[0.1,0.5]",
        f"plugins=[{folder / 'Läufe' / 'middle.py'}]",
        "method=direct",
        "optimizer=middle",
        "repetitions=1",
        "workers=1",
        "name=Größe",
        "output=Ergebnis, µ=2",
        cwd=folder,
        output="Ergebnis, µ=2",
    )
    assert (done.code, done.err) == (0, ""), done.err
    assert done.table("Größe")["runs"].eq(1).all() and np.isfinite(done.table("Größe")["median"][:5]).all()
    again = apart("status", "Ergebnis, µ=2", cwd=folder)
    assert again.code == 0 and "done      1" in again.out


@pytest.mark.parametrize(
    "word, expected",
    [
        ("output=µ=2, a", "µ=2, a"),
        ("output=Prüfstand 1", "Prüfstand 1"),
        ("output=results/plain", "results/plain"),
        ("measurement.path=fleet/*.csv", "fleet/*.csv"),
        ("problem.file=Läufer (alt).yaml", "Läufer (alt).yaml"),
        ("output='quoted, as before'", "quoted, as before"),
        ("plugins=[Prüfstand/my.py]", ["Prüfstand/my.py"]),
        ("share=[a,b]", ["a", "b"]),
    ],
)
def test_what_the_grammar_cannot_read_is_taken_as_it_stands(word, expected):
    [choice] = parse(with_quoted_files([word]))
    assert choice.values == (expected,)


def test_a_file_that_is_there_comes_before_a_list(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert parse(with_quoted_files(["measurement.path=a,b.csv"]))[0].values == ("a", "b.csv")
    (tmp_path / "a,b.csv").touch()
    assert parse(with_quoted_files(["measurement.path=a,b.csv"]))[0].values == ("a,b.csv",)


def test_other_settings_stay_as_they_are():
    words = ["samples=40,70", "grid=[{label: A, samples: 40}]", "measurement.relative=0.1", "output=${name}"]
    assert with_quoted_files(words) == words
