"""Separation margins and the static sag of a rotor as tables."""

from __future__ import annotations

import pandas as pd

from ksmea.rotordynamics.whirl import Rotordynamics
from ksmea.units import MICROMETRE, RPM


def margin_frame(found: Rotordynamics) -> pd.DataFrame:
    """A row for each peak of the response, with the separation margin that it has and needs."""
    return pd.DataFrame(
        [
            {
                "peak_rpm": each.peak.speed / RPM,
                "probe": str(each.peak.channel),
                "amplification_factor": each.peak.amplification_factor,
                "side": each.side,
                "margin_pct": 100 * each.actual,
                "required_pct": 100 * each.required,
                "is_met": each.is_met,
            }
            for each in found.margins
        ],
        columns=["peak_rpm", "probe", "amplification_factor", "side", "margin_pct", "required_pct", "is_met"],
    )


def margin_table(found: Rotordynamics) -> pd.DataFrame:
    """Separation margins as texts."""
    rows = []
    for each in found.margins:
        verdict = "none needed" if each.required == 0 and each.side != "inside" else "met" if each.is_met else "not met"
        rows.append(
            {
                "peak (rpm)": f"{each.peak.speed / RPM:.0f}",
                "probe": str(each.peak.channel),
                "amplification factor": f"{each.peak.amplification_factor:.3g}",
                "margin (%)": f"{100 * each.actual:.1f} {each.side}" if each.side != "inside" else "inside",
                "API 617 (%)": f"{100 * each.required:.1f}",
                "verdict": verdict,
            }
        )
    return pd.DataFrame(rows)


def sag_frame(found: Rotordynamics) -> pd.DataFrame:
    """A row for each node: how far the shaft sags under its weight."""
    layout = found.layout
    if layout.sag is None:
        return pd.DataFrame(columns=["position_m", "sag_um"])
    return pd.DataFrame({"position_m": layout.node_positions, "sag_um": layout.sag / MICROMETRE})
