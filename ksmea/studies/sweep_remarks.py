"""Remarks on the rate of a sweep that a diagnosis finds, beside the one that times or rows give: the fit has not seen that."""

from __future__ import annotations

from ksmea.diagnosis.diagnosis import Diagnosis
from ksmea.speed_history import ACCELERATION, SpeedHistory
from ksmea.units import RPM


def sweep_remarks(found: Diagnosis, history: SpeedHistory | None) -> tuple[str, ...]:
    """Whether the two rates agree, and whether the speed went at a constant one; nothing where no rate is known."""
    if history is None or history.rates is None or history.rate is None:
        return ()
    given = "the times give" if history.from_times else "the rows, if each is a turn of the shaft, give"
    said = []
    if not history.is_constant:
        first, second = (rate / RPM for rate in history.rates)
        said.append(
            f"{given} {first:.3g} rpm/s in the first half of the run and {second:.3g} rpm/s in the second: a sweep at a constant"
            " rate is an approximation"
        )
    if found.best is None or found.best_estimate is None or ACCELERATION not in found.best.problem.parameters.names:
        return tuple(said)
    index = found.best.problem.parameters.names.index(ACCELERATION)
    interval, rate = found.best_estimate.intervals[index], found.best_estimate.x[index]
    agree = interval.low <= history.rate <= interval.high
    verdict = "they agree" if agree else "they disagree, as where the model lacks something besides the sweep"
    fitted = f"{rate / RPM:.3g} [{interval.low / RPM:.3g}, {interval.high / RPM:.3g}]"
    return (*said, f"{given} {history.rate / RPM:.3g} rpm/s, the fit {fitted} rpm/s: {verdict}")
