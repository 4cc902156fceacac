"""Results of one experiment that were computed on several kinds of processors, here on two kernels of OpenBLAS."""

import dataclasses
import platform
import shutil
from collections import Counter

import pytest
from threadpoolctl import threadpool_info

from bench.commands.reference import write_reference
from bench.jobs.processors import processors
from bench.plan.plan import read_plan, write_plan
from ksmea.errors import SettingError

KERNELS = ("Nehalem", "Prescott")  # every x86_64 processor can run them; OpenBLAS calls the second one Katmai
HERE = {pool["internal_api"] for pool in threadpool_info() if pool["user_api"] == "blas"}
MIXED = (
    "note: runs were computed on several kinds of processors (x86_64 Nehalem: 4, x86_64 Katmai: 2): results may differ"
)


@pytest.fixture(scope="module")
def resumed(shell, cheapest, tmp_path_factory):
    """A sweep that was begun on one kernel and ended on another."""
    if platform.machine() != "x86_64" or HERE != {"openblas"}:
        pytest.skip("needs OpenBLAS on x86_64, whose kernel can be chosen")
    folder = tmp_path_factory.mktemp("resumed")
    calls = [
        shell(*cheapest, f"repetitions={n}", "seed=0,1", cwd=folder, output="results/run", OPENBLAS_CORETYPE=kernel)
        for n, kernel in zip((2, 3), KERNELS)
    ]
    assert [(each.code, each.err) for each in calls] == [(0, "")] * 2
    return calls


@pytest.mark.slow
def test_each_session_says_on_what_it_computed(resumed):
    assert [line["platform"] for line in resumed[1].events("session")] == ["x86_64 Nehalem", "x86_64 Katmai"]
    assert Counter(processors(resumed[1].output).values()) == {"x86_64 Nehalem": 4, "x86_64 Katmai": 2}


@pytest.fixture
def here(resumed, tmp_path):
    """A copy of its results in the test's own working directory."""
    shutil.copytree(resumed[1].output, tmp_path / "results/run")


@pytest.mark.slow
def test_a_mixture_is_told_below_the_table_and_by_status(resumed, here, enter):
    """Nothing is stale: the runs of the first kernel stay, and it is said."""
    first, second = resumed
    assert "several kinds of processors" not in first.out and MIXED in second.out
    status = enter("status", "run")
    assert status.code == 0 and MIXED in status.out and "stale      0" in status.out
    assert MIXED in enter("collect", "run").out


@pytest.mark.slow
def test_explain_names_the_kernel_of_a_run(resumed, here, enter):
    runs = resumed[1].runs()
    for repetition, kernel in ((0, "Nehalem"), (2, "Katmai")):
        key = runs.loc[runs["repetition"] == repetition, "key"].iloc[0]
        assert enter("explain", key).out.splitlines()[-1] == f"done on x86_64 {kernel}"


@pytest.mark.slow
def test_runs_that_are_taken_over_keep_the_kernel_that_computed_them(resumed, shell, cheapest):
    """A second folder, on the second kernel, that takes over what the first kernel computed."""
    words = [*cheapest, "repetitions=2", "seed=0,1", "output=results/other", "share=[results/run]"]
    folder = resumed[1].output.parents[1]
    other = shell(*words, cwd=folder, output="results/other", OPENBLAS_CORETYPE=KERNELS[1])
    assert (other.code, other.err) == (0, "") and other.events("started") == []
    assert set(processors(other.output).values()) == {"x86_64 Nehalem"}


@pytest.mark.slow
def test_no_reference_is_made_of_a_mixture(resumed, tmp_path):
    write_plan(dataclasses.replace(read_plan(resumed[1].output), commit="c0de"), resumed[1].output)  # as if committed
    with pytest.raises(SettingError, match="expected results of one kind of processor, but runs were computed on"):
        write_reference(resumed[1].output, tmp_path / "reference")
    assert not (tmp_path / "reference").exists()
