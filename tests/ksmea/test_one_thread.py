"""Functions of the public door compute with one thread of BLAS, and give the former number back."""

from typing import ClassVar

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import ksmea
from ksmea.numerics.one_thread import one_blas_thread
from ksmea.plugins.optimizer import Optimizer


def threads():
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


class Watching(Optimizer):
    """Notes the threads of BLAS while it searches."""

    seen: ClassVar[list[set[int]]] = []

    def minimize(self, objective, rng):
        self.seen.append(threads())
        objective(rng.random((20, objective.dim)))
        return objective.result()


def test_a_study_runs_with_one_thread_and_gives_the_others_back():
    rotor = ksmea.load_problem("three_disk", n_speed=20)
    data = ksmea.synthetic_measurement(rotor, relative=0.05, rng=np.random.default_rng(0))
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        ksmea.identify(rotor, data, optimizer=Watching(), intervals="none")
        assert Watching.seen == [{1}] and threads() == before


def test_threads_come_back_after_an_error():
    @one_blas_thread
    def fails():
        assert threads() == {1}
        raise ValueError("as it happens")

    with threadpool_limits(2, user_api="blas"):
        before = threads()
        with pytest.raises(ValueError, match="as it happens"):
            fails()
        assert threads() == before
