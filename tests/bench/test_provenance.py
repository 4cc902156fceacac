"""Staleness of a result: a change of the code that computes it, and no other."""

import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from bench.plan.provenance import code_digest, used_modules
from bench.storage.own_files import ROOT
from ksmea.plugins.registry import GROUPS

CHOSEN = dict.fromkeys(GROUPS) | {
    "problem": {"name": "three_disk"},
    "measurement": {"name": "synthetic"},
    "surrogate": {"name": "kriging"},
    "optimizer": {"name": "de"},
    "method": {"name": "ksmea"},
}


DETAILED = {"parts": ["study=identify_in_detail"]}


def test_a_run_uses_its_plugins_and_all_that_they_import():
    used = used_modules(CHOSEN)
    chosen = {
        "optimizers.de",
        "ksmea.numerics.isolation",
        "surrogates.kriging",
        "surrogates.theta_search",
        "ksmea.identification.ksmea",
    }
    physics = {
        "problems.three_disk",
        "problems.rotor.response.receptance",
        "problems.rotor.finite_elements.shaft",
        "ksmea.likelihood.misfit",
        "bench.jobs.execute",
    }
    assert chosen | physics <= used.keys()


def test_a_run_does_not_use_other_plugins_nor_what_prints_results():
    used = used_modules(CHOSEN)
    assert (
        not {
            "optimizers.ga",
            "surrogates.rsm",
            "bench.reports.identification.spread_chart",
            "bench.reports.tables",
            "bench.main",
        }
        & used.keys()
    )


FAR_FROM_A_FIT = ("diagnosis", "location", "nonlinear", "show", "balancing")  # folders of ksmea


@pytest.mark.parametrize(
    "study",
    [{"study": {"name": "identify"}}, {"study": {"name": "identifiability"}, "optimizer": None, "surrogate": None}],
    ids=["identification", "CRLB"],
)
def test_a_plain_run_uses_no_more_than_it_needs(study):
    """So that a constant changed in the diagnosis leaves finished identifications and CRLB studies fresh."""
    used = used_modules(CHOSEN | study)
    assert not [name for name in used if name.split(".")[:2] in [["ksmea", folder] for folder in FAR_FROM_A_FIT]]
    assert len(used) <= 130  # seven of which are of numbers known to a tolerance


def test_details_of_an_identification_use_what_they_show():
    plain, detailed = (used_modules(CHOSEN | {"study": {"name": "identify"}} | parts) for parts in ({}, DETAILED))
    assert plain.items() <= detailed.items()
    assert {"ksmea.studies.misreadings", "ksmea.location.location"} <= detailed.keys() - plain.keys()


def test_what_a_method_ignores_is_not_used():
    used = used_modules(CHOSEN | {"surrogate": None, "method": {"name": "direct"}})
    assert "surrogates.kriging" not in used
    assert "ksmea.identification.ksmea" not in used


def test_a_library_of_an_extra_belongs_to_the_runs_that_import_it():
    assert "distribution cma" not in used_modules(CHOSEN)
    assert used_modules(CHOSEN | {"optimizer": {"name": "cmaes"}})["distribution cma"] == version("cma")


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """A copy of the source whose files a test may edit."""
    place = tmp_path_factory.mktemp("copy")
    for package in ("bench", "ksmea", "optimizers", "problems", "surrogates"):
        shutil.copytree(ROOT / package, place / package, ignore=shutil.ignore_patterns("__pycache__"))
    return place


def digest_in(place):
    program = f"from bench.plan.provenance import *; print(code_digest(used_modules({CHOSEN!r})))"
    done = subprocess.run([sys.executable, "-c", program], cwd=place, capture_output=True, text=True, check=True)
    return done.stdout.strip()


@pytest.mark.parametrize(
    ("file", "old", "new", "is_stale"),
    [
        ("surrogates/theta_search.py", "VARIANCE_FLOOR = 1e-20", "VARIANCE_FLOOR = 1e-19", True),
        ("problems/rotor/finite_elements/shaft.py", "import numpy as np", "import numpy as np\n\nDENSITY = 1.0", True),
        ("optimizers/ga.py", "import numpy as np", "import math\n\nimport numpy as np", False),
        ("ksmea/location/force_law.py", "N_FIRST = ", "N_SECOND = 1\nN_FIRST = ", False),
        ("bench/reports/identification/spread_chart.py", "COLUMNS = 5", "COLUMNS = 4", False),
        ("ksmea/identification/ksmea.py", "import time", "# a remark\nimport   time", False),
        ("ksmea/identification/ksmea.py", '"""KSMEA: ', '"""KSMEA, in other words: ', False),
    ],
    ids=["constant", "physics", "other plugin", "far from it", "presentation", "comment", "docstring"],
)
def test_an_edit_makes_stale_what_is_computed_by_it(copy, file, old, new, is_stale):
    before = digest_in(copy)
    path = Path(copy, file)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    try:
        assert (digest_in(copy) != before) is is_stale
    finally:
        path.write_text(text, encoding="utf-8")


def test_the_digest_does_not_depend_on_the_place_of_the_source(copy):
    assert digest_in(copy) == code_digest(used_modules(CHOSEN))
