"""Kriging by pydacefit (Blank), DACE of Lophaven, Nielsen & Søndergaard (2002) in Python: linear trend, anisotropic Gaussian
correlation, all outputs with one θ, found by DACE's pattern search."""

from __future__ import annotations

import numpy as np
from pydacefit.corr import corr_gauss
from pydacefit.dace import DACE
from pydacefit.regr import regr_linear

from benchmarks.harness.task import Task
from benchmarks.tasks.responses import fit_by, predict_by


def fitted(u: np.ndarray, y: np.ndarray) -> DACE:
    """θ counts in standardised coordinates there, whose variance in a unit cube is 1/12: our limits divided by 12."""
    d = u.shape[1]
    model = DACE(
        regr_linear, corr_gauss, theta=np.full(d, 0.2), thetaL=np.full(d, 1e-3 / 12), thetaU=np.full(d, 1e3 / 12)
    )
    model.fit(u, y)
    return model


def fit(samples: str) -> Task:
    return fit_by(fitted, samples)


def predict(samples: str, points: int) -> Task:
    return predict_by(fitted, samples, points)
