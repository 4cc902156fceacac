"""What a report says of the runs that its data come from."""

from __future__ import annotations

from ksmea.errors import SettingError
from ksmea.measurement import Measurement


def campaign_remarks(measurement: Measurement) -> tuple[str, ...]:
    """The runs with their weights and what they share; nothing of a single one."""
    campaign = measurement.campaign
    if campaign is None:
        return ()
    said = [f"{', '.join(campaign.own)} of its own for each" if campaign.own else "all unknowns shared"]
    said += ["noise of its own for each"] if campaign.own_noise else []
    if campaign.reference:
        said.append(f"by differences from run {campaign.reference}: what is alike in all runs cancels")
    return (f"{campaign}; {'; '.join(said)}",)


def refuse_differences(measurement: Measurement, study: str) -> None:
    """Raise `SettingError` where differences between runs are to be studied that have no use for them."""
    if measurement.is_by_differences:
        raise SettingError(
            f"reference: expected all that the runs show, of which {study} looks for a cause, got differences between them;"
            " leave measurement.reference out, or identify with it"
        )
