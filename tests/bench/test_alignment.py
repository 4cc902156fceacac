"""Measurements that do not belong to the problem, from the command line: one line, and no result."""

import pytest

from outside_package import outside_package

METADATA = "Metadata-Version: 2.1\nName: rigs\nVersion: 1.0\n"
ENTRY_POINTS = "[ksmea.measurements]\nrig = rigs:Rig\n"
RIG = '''
from dataclasses import dataclass

import numpy as np

from ksmea import MeasurementSource
from ksmea.measurement.measurement import Layout, Measurement, Noise
from ksmea.settings.settings import setting


@dataclass(frozen=True)
class Rig(MeasurementSource):
    """A rig that measures at other speeds than it says, where told."""

    off_by: float = setting(0.0, "rad/s between the speeds that it measures at and those that it says", unit="rad/s")
    says: bool = setting(True, "whether it says before a run where it measures")

    kind = "amplitude"

    def measure(self, settings, truth, noise, hidden):
        problem = settings.build()
        problem = problem.at(problem.speed[:7] + self.off_by, problem.channels)
        x = np.array([settings.reference()[name] for name in problem.parameters.names])
        values = np.abs(problem.response(x[None])[0])
        return Measurement(problem.speed, problem.channels, values, Noise(0.05, 0.0), "rig")

    def layout(self, settings):
        if not self.says:
            return super().layout(settings)
        problem = settings.build()
        return Layout(problem.speed[:7], problem.channels, "amplitude", "rig")
'''
DIRECT = ["method=direct", "optimizer.generations=2", "measurement=rig", "repetitions=1", "workers=1"]


@pytest.fixture
def enter_with_rig(enter, tmp_path_factory, monkeypatch):
    """The bench inside this process with the measurement source of someone else, which is forgotten afterwards."""
    folder = tmp_path_factory.mktemp("packages")
    information = "rigs-1.0.dist-info"
    files = {
        "rigs.py": RIG,
        f"{information}/METADATA": METADATA,
        f"{information}/entry_points.txt": ENTRY_POINTS,
    }
    with outside_package(folder, monkeypatch, files):
        yield enter


@pytest.mark.parametrize("words", [[], ["measurement.off_by=25", "measurement.says=false"]])
def test_a_source_from_outside_sets_speeds_and_channels(enter_with_rig, words):
    ended = enter_with_rig(*DIRECT, *words)
    assert ended.code == 0, ended.err
    [cell] = ended.cells()
    assert all(facts["truth"] is None for facts in cell["parameters"])  # the defaults of a source: no truth is known


def test_a_source_that_measures_at_other_speeds_than_it_says_gives_no_result(enter_with_rig):
    ended = enter_with_rig(*DIRECT, "measurement.off_by=25")
    assert ended.code == 1
    [error] = ended.runs()["error"]
    assert "speed 1: expected 225 rad/s as measured, got a problem at 200 rad/s" in error and "\n" not in error


@pytest.mark.parametrize("study", ["identify", "diagnose"])
def test_a_file_with_a_channel_off_the_shaft_is_refused_before_any_run(enter, tmp_path, study):
    (tmp_path / "run.csv").write_text(
        "speed_rpm,position_m,direction,amplitude_um_0pk\n1000,0.1,x,2\n1000,9,x,3\n1200,0.1,x,2\n1200,9,x,3\n"
    )
    words = [f"+experiment={study}", "measurement=file", f"measurement.path={tmp_path / 'run.csv'}"]
    ended = enter(*words, output="results/mine")
    assert ended.code == 2 and ended.err.count("\n") == 1
    assert "run.csv line 3: sensor at 9 m: expected a position on the shaft" in ended.err
