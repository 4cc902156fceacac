"""The predictive gain of an extended model in sentences."""

from __future__ import annotations

from ksmea.records.extension import PredictiveGainRecord
from ksmea.show.text import number, with_error
from ksmea.units import MICROMETRE


def gain_lines(gain: PredictiveGainRecord) -> list[str]:
    """Whether left-out data support the extension, and by how much."""
    supported = "supported" if gain.is_supported else "not supported"
    tests = f"sign test p = {gain.p_sign:.2g}, signed-rank p = {gain.p_wilcoxon:.2g}"
    blocks = f"it predicts {gain.n_better} of {len(gain.by_block)} blocks of speeds better ({tests})"
    in_all = with_error(gain.elpd_difference, gain.standard_error, "+")
    elpd = f"{number(gain.median, 3, '+')} in the median block and {in_all} in all"
    rmse = f"{gain.rmse_before / MICROMETRE:.3g} to {gain.rmse_after / MICROMETRE:.3g} µm"
    return [
        f"The extension is {supported} by left-out data: {blocks}.",
        f"Its elpd difference is {elpd}; the rms error goes from {rmse}.",
    ]
