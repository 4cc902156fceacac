"""Module paths of before the floors, which outside plugins may import from for one more release."""

import importlib
import subprocess
import sys

import pytest

import ksmea
from ksmea.measurement.measurement import OBSERVABLES
from ksmea.problem.response_structure import ResponseStructure
from surrogates.kriging import Kriging
from surrogates.rsm import ResponseSurface

PLUGIN = """
from dataclasses import dataclass

from ksmea.alignment import aligned
from ksmea.channel import DIRECTIONS, Channel
from ksmea.contracts import Effect, MeasurementSource, Method, Optimizer, Problem, ProblemSettings, Surrogate
from ksmea.direct import Direct
from ksmea.identification import Identification, Streams
from ksmea.measurement import Noise
from ksmea.objective import Minimum, Objective
from ksmea.parameters import Parameter, Parameters
from ksmea.predictor import Predictor
from ksmea.settings import part, setting
from ksmea.unsuited import Unsuited


@dataclass(frozen=True)
class Centre(Optimizer):
    width: float = setting(0.0, "how far from the centre", at_least=0.0)

    def minimize(self, objective: Objective, rng) -> Minimum:
        objective(rng.random((3, objective.dim)))
        return objective.result()
""".replace("Measurement{comma}", "MeasurementSource, ")
OLD = {
    "ksmea.channel.Channel": ksmea.Channel,
    "ksmea.contracts.Effect": ksmea.Effect,
    "ksmea.contracts.Problem": ksmea.Problem,
    "ksmea.measurement.KINDS": OBSERVABLES,
    "ksmea.measurement.Measurement": ksmea.Measurement,
    "ksmea.measurement.Noise": ksmea.Noise,
    "ksmea.objective.Objective": ksmea.Objective,
    "ksmea.predictor.Predictor": ksmea.Predictor,
    "ksmea.settings.setting": ksmea.setting,
}


@pytest.mark.parametrize("path", OLD)
def test_what_an_old_path_names_is_what_the_new_one_does_and_it_warns(path):
    module, _, name = path.rpartition(".")
    if module not in ("ksmea.measurement", "ksmea.settings"):  # packages warn by name, modules when they are imported
        sys.modules.pop(module, None)
    with pytest.warns(DeprecationWarning, match=f"^{module}.* has moved to ksmea"):
        assert getattr(importlib.import_module(module), name) is OLD[path]


@pytest.mark.parametrize("package", ["identification", "measurement", "settings"])
def test_a_name_that_an_old_module_did_not_have_is_missing_as_ever(package):
    assert not hasattr(importlib.import_module(f"ksmea.{package}"), "nonsense")


@pytest.mark.slow
def test_a_plugin_that_imports_from_old_paths_runs(tmp_path):
    (tmp_path / "centre.py").write_text(PLUGIN)
    words = ["+experiment=table3", "plugins=[centre.py]", "method=direct", "optimizer=centre", "repetitions=1"]
    done = subprocess.run(
        [sys.executable, "-m", "bench", *words], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_project_itself_imports_from_none_of_them():
    """In a process of its own, in which nothing is imported yet."""
    code = (
        "import warnings; warnings.simplefilter('error', DeprecationWarning);"
        "from importlib.metadata import entry_points;"
        "[point.load() for group in entry_points().groups if group.startswith('ksmea.') for point in entry_points(group=group)"
        " if point.dist.name == 'ksmea-bench']; import bench.run_experiment, ksmea.api"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    moved = [line for line in done.stderr.splitlines() if "has moved to" in line]
    assert not moved, done.stderr


def test_a_surrogate_that_overrides_told_of_still_works_and_warns():
    """`told_of` is the earlier name of `with_structure`."""
    with pytest.warns(
        DeprecationWarning, match=r"^Old\.told_of has been renamed with_structure; override that$"
    ) as caught:

        class Old(ResponseSurface):
            def told_of(self, structure):
                return Kriging()

    assert [each.filename for each in caught] == [__file__]

    class New(ResponseSurface):
        def with_structure(self, structure):
            return Kriging()

    plain, structure = ResponseSurface(), ResponseStructure.__new__(ResponseStructure)
    assert New().told_of(structure) == New().with_structure(structure) == Kriging()
    assert Old().with_structure(structure) == Kriging()
    assert plain.with_structure(structure) is plain and plain.told_of(structure) is plain
