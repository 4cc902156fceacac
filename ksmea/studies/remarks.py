"""Remarks of a report on the runs of a campaign.

Studies that have no use for differences between runs.
"""

from __future__ import annotations

from ksmea.errors import SettingError
from ksmea.measurement.measurement import Measurement
from ksmea.problem.case import Case
from ksmea.problem.trial_weights import disk_positions, is_on


def campaign_remarks(case: Case) -> tuple[str, ...]:
    """The runs with their weights and what they share, and weights on no disk; nothing of a single run."""
    campaign = case.measurement.campaign
    if campaign is None:
        return ()
    said = [f"{', '.join(campaign.own)} of its own for each" if campaign.own else "all unknowns shared"]
    said += ["noise of its own for each"] if campaign.own_noise else []
    if campaign.reference:
        said.append(f"by differences from run {campaign.reference}: what is alike in all runs cancels")
    return (f"{campaign}; {'; '.join(said)}", *_on_no_disk(case))


def _on_no_disk(case: Case) -> list[str]:
    """Remarks on weights that sit on no disk, if the problem knows its disks."""
    disks, campaign = disk_positions(case.problem), case.measurement.campaign
    if campaign is None or not disks:
        return []
    where = ", ".join(f"{name} at {place:g} m" for name, place in disks.items())
    return [
        f"run {run.name}: {weight} sits on no disk ({where}); if that is a slip, mend its position"
        for run in campaign.runs
        for weight in run.all_weights
        if not any(is_on(weight.position, place) for place in disks.values())
    ]


def refuse_differences(measurement: Measurement, study: str) -> None:
    """Raise `SettingError` where differences between runs are to be studied that have no use for them."""
    if measurement.is_by_differences:
        raise SettingError(
            f"reference: expected all that the runs show, of which {study} looks for a cause, got differences between them;"
            " leave measurement.reference out, or identify with it"
        )
