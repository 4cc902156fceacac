"""`+experiment=locate` as its users meet it: sentences, location.json, a table of sites, a figure; many runs counted."""

import json

import pandas as pd
import pytest

from bench.reports.diagnosis.location_report import counts_line

DATA = [
    "measurement.kind=complex",
    "measurement.relative=0.05",
    "measurement.floor=0.05",
    "measurement.noise_known=false",
    "measurement.mesh=26",
    "measurement.route=dense",
    "measurement.hidden=[unbalance]",
    "measurement.sizes={unbalance_x: 60.0, unbalance_y: 30.0}",
    "problem.sensors=[0.1,0.5,1.0]",
    "problem.n_speed=20",
    "seed=2",
]
FEW = ["study.positions=[0.2,0.6,1.0]", "study.kinds=[force]"]


@pytest.fixture(scope="module")
def located(apart, tmp_path_factory):
    return apart(
        "+experiment=locate", *DATA, *FEW, draws=True, cwd=tmp_path_factory.mktemp("located"), output="results/locate"
    )


def test_it_says_where_something_acts_and_writes_what_it_found(located):
    assert located.code == 0, located.err
    assert "The model does not fit" in located.out
    assert "An unknown force that is free at every speed explains the data at " in located.out
    assert "it is an unbalance (a force ∝ Ω² that turns with the shaft): " in located.out
    assert "The extension is supported by left-out data: it predicts 6 of 6 blocks" in located.out
    assert "written: location.json, extended.yaml, sites.csv, location.png" in located.out
    found = json.loads((located.output / "location.json").read_text())
    assert found["kind"] == "force" and found["law_status"] == "found" and "hidden" not in found
    accepted = [site["position"] for site in found["candidates"] if site["accepted"]]
    [run] = pd.read_csv(located.output / "runs.csv").to_dict("records")
    true = float(run["hidden"].split("at ")[1].split(" m")[0])
    assert true in accepted
    assert found["force"]["position"] == true  # the law tells it from its neighbours
    assert (located.output / "location.png").stat().st_size > 0
    assert list(pd.read_csv(located.output / "sites.csv").columns)[:2] == ["kind", "position_m"]


@pytest.mark.parametrize(
    "words, said",
    [
        (
            ["+experiment=identify", "measurement=synthetic", "optimizer.screening=500", "optimizer.starts=2"],
            "local_u_x = ",
        ),
        (["+experiment=identifiability", "study.variations=[]"], "local_u_y"),
        (["+experiment=plan", "study.target=local_u_x", "study.add=1", "study.sensors=0"], "local_u_x"),
        (["+experiment=diagnose", "study.effects=[runout]", "study.screening=256"], "The model explains the data"),
        (["+experiment=locate", *FEW], "nothing needs to be located"),
    ],
)
def test_the_extended_model_is_one_for_every_study_from_any_folder(located, enter, words, said):
    """Data of the located model itself, wherever the study is run."""
    extended = ["problem=extended", f"problem.file={located.output / 'extended.yaml'}", "repetitions=1"]
    noise = ["measurement.kind=complex", "measurement.relative=0.05", "measurement.floor=0.05"]
    ended = enter(*words, *extended, *noise, "workers=1")
    assert ended.code == 0, ended.err
    assert said in ended.out


@pytest.mark.slow
def test_a_law_of_older_results_goes_with_its_file(enter, tmp_path):
    """A location where nothing is missing writes no extended model, and takes that of other data away."""
    (tmp_path / "results" / "locate").mkdir(parents=True)
    (tmp_path / "results" / "locate" / "extended.yaml").write_text("old")
    hidden = ("measurement.hidden", "measurement.sizes")
    plain = [word for word in DATA if not word.startswith(hidden)]
    ended = enter("+experiment=locate", *plain, *FEW, output="results/locate")
    assert ended.code == 0 and "nothing needs to be located" in ended.out
    assert not (ended.output / "extended.yaml").exists() and "extended.yaml" not in ended.out


@pytest.mark.slow
def test_many_runs_are_counted(enter):
    ended = enter("+experiment=locate", *DATA, *FEW, "repetitions=2", output="results/locate")
    assert ended.code == 0, ended.err
    assert "accepted (median)" in ended.out
    runs = pd.read_csv(ended.output / "runs.csv")
    assert len(runs) == 2 and {"kind", "accepted", "kxx", "kxx_low", "kxx_high", "kxx_plain"} <= set(runs)
    assert not (ended.output / "location.json").exists()


@pytest.mark.parametrize(
    "words, what",
    [
        (["measurement.kind=amplitude"], "measure phases too"),
        (["problem.sensors=[0.1]"], "add a probe at another plane"),
        (["measurement.relative=0", "measurement.floor=0"], "expected noise"),
        (["study.kinds=[torque]"], "unknown kind"),
    ],
)
def test_what_cannot_be_located_is_refused_in_one_line(enter, words, what):
    ended = enter("+experiment=locate", *DATA, *words)
    assert ended.code == 2 and what in ended.err and len(ended.err.strip().splitlines()) == 1


def test_kinds_without_a_site_are_told_in_words():
    runs = pd.DataFrame({"kind": ["none", "force", "none", "nothing"]})
    assert counts_line(runs) == "located: 2 unexplained, 1 force, 1 with nothing missing"
    assert counts_line(pd.DataFrame({"status": ["error"]})) == "no run has a result"
