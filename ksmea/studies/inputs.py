"""Numbers that are known to a tolerance, as records: what a joint fit says of each, and what an unknown's uncertainty comes from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.fits.fitting import Fit
from ksmea.inference.input_budget import input_budget
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
    for index, sd, pull, contradicted in zip(fit.inputs, budget.sd, budget.pull, budget.is_contradicted):
        item = parameters.items[index]
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
    """What the uncertainty of each of these unknowns comes from, SI."""
    parameters = fit.problem.parameters
    budget = input_budget(fit.point, parameters)
    names = [parameters.items[index].words or parameters.items[index].name for index in fit.inputs]
    found = []
    for index in own:
        width = parameters.items[index].upper - parameters.items[index].lower
        variances = budget.by_input[index] ** 2
        total = float(np.sum(variances) + budget.by_noise[index] ** 2)
        shares = [(name, float(each / total)) for name, each in zip(names, variances) if each > LEAST_SHARE * total]
        shares.sort(key=lambda share: -share[1])
        sd_inputs = float(np.sqrt(np.sum(variances))) * width
        found.append(Origin(float(budget.by_noise[index]) * width, sd_inputs, tuple(shares[:N_SHARE])))
    return tuple(found)
