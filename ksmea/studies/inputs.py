"""Numbers that are known to a tolerance, as records.

They have the result of a joint fit for each, and the origin of an unknown's uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.fits.fitting import Fit
from ksmea.inference.input_budget import input_budget
from ksmea.problem.parameters import Parameters
from ksmea.records.inputs import InputRecord, Origin

N_SHARE = 5  # numbers that are named, at most
LEAST_SHARE = 0.01  # of the variance of an unknown


def input_records(fit: Fit) -> tuple[InputRecord, ...]:
    """Each number of a joint fit as stated and as found; none of a fit whose numbers are exact."""
    parameters = fit.problem.parameters
    if not len(fit.inputs):
        return ()
    budget, x = input_budget(fit.point, parameters), fit.x
    found = []
    for index, sd, pull, contradicted in zip(parameters.with_prior, budget.sd, budget.pull, budget.is_contradicted):
        item = parameters.items[index]
        if not item.is_input:
            continue
        assert item.prior is not None, "an unknown without a prior"
        found.append(
            InputRecord(
                *(item.name, item.words or item.name, item.unit, item.si_per_unit),
                stated=item.prior.value,
                stated_sd=item.prior.sd,
                value=float(x[index]),
                sd=float(sd * (item.upper - item.lower)),
                pull=float(pull),
                is_contradicted=bool(contradicted),
            )
        )
    return tuple(found)


def origins_of(fit: Fit, own: Sequence[int]) -> tuple[Origin, ...]:
    """Origins of the uncertainty of each of these unknowns, SI."""
    parameters = fit.problem.parameters
    budget, width = input_budget(fit.point, parameters), parameters.width
    return origins(parameters, own, budget.by_noise * width, budget.by_input * width[:, None])


def origins(parameters: Parameters, own: Sequence[int], by_noise: Array, by_input: Array) -> tuple[Origin, ...]:
    """Shares of noise and priors in the uncertainty of some unknowns.

    They follow from the standard deviations (SI) that noise (d,) and each prior (d, n_prior) cause.
    """
    items = [parameters.items[index] for index in parameters.with_prior]
    names = [item.words or item.name for item in items]
    found = []
    for index in own:
        variances = by_input[index] ** 2
        total = float(np.sum(variances) + by_noise[index] ** 2)
        shares = [(name, float(each / total)) for name, each in zip(names, variances) if each > LEAST_SHARE * total]
        shares.sort(key=lambda share: -share[1])
        found.append(Origin(float(by_noise[index]), float(np.sqrt(np.sum(variances))), tuple(shares[:N_SHARE])))
    return tuple(found)
