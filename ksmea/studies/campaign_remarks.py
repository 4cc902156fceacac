"""What a report says of the runs that its data come from."""

from __future__ import annotations

from ksmea.measurement import Measurement


def campaign_remarks(measurement: Measurement) -> tuple[str, ...]:
    """The runs with their weights and what they share; nothing of a single one."""
    campaign = measurement.campaign
    if campaign is None:
        return ()
    own = f"{', '.join(campaign.own)} of its own for each" if campaign.own else "all unknowns shared"
    return (f"{campaign}; {own}",)
