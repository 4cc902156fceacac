"""A problem that stands before another one: what it does not do itself it hands on."""

from __future__ import annotations

from ksmea.arrays import Array
from ksmea.campaign import Campaign
from ksmea.channel import Channel
from ksmea.contracts import Problem
from ksmea.parameters import Parameters


class ProblemProxy(Problem):
    """Base of problems that see to what another one, `behind`, is asked. Members of the contract that a subclass leaves out
    are those of the problem behind; `linearised` is made of its own response and sensitivity."""

    parameters: Parameters
    speed: Array
    channels: tuple[Channel, ...]
    campaign: Campaign | None

    def __init__(self, behind: Problem) -> None:
        self._behind = behind


def _handed_on(name: str) -> property:
    return property(lambda self: getattr(self._behind, name))


for _name in (*ProblemProxy.__annotations__, *vars(Problem)):
    if not _name.startswith("_") and _name not in ("response", "linearised"):
        setattr(ProblemProxy, _name, _handed_on(_name))
