"""A problem that stands before another one: what it does not do itself it hands on."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.campaign import Run
from ksmea.measurement.channel import Channel
from ksmea.problem.load import Load
from ksmea.problem.problem import Problem
from ksmea.problem.response_structure import UnknownImpedance


class ProblemProxy(Problem):
    """Base of proxies for another problem, `behind`.

    Forwards every member of the contract that a subclass does not override.

    `linearised`, `response_and_per_load` and `linearised_per_load` are made of the proxy's own members. A proxy with unknowns of
    its own must also make of its own members whatever the contract makes of others.
    """

    @property
    @abstractmethod
    def behind(self) -> Problem: ...

    @abstractmethod
    def around(self, behind: Problem) -> Problem:
        """This proxy for another problem: the one behind, changed."""

    def at(self, speed: Array, channels: Sequence[Channel]) -> Problem:
        return self.around(self.behind.at(speed, channels))

    def going(self, run: Run) -> Problem:
        return self.around(self.behind.going(run))

    def next_to(self, motion: ComplexArray) -> Problem:
        return self.around(self.behind.next_to(motion))

    @property
    def machine(self) -> Problem:
        return self.around(self.behind.machine)

    def changed(self, change: Callable[[Problem], Problem]) -> Problem:
        return self.around(self.behind.changed(change))

    @property
    def joint(self) -> Problem:
        joint = self.behind.joint
        return self if joint is self.behind else self.around(joint)

    @property
    def as_stated(self) -> Problem:
        stated = self.behind.as_stated
        return self if stated is self.behind else self.around(stated)

    def holding_inputs(self, x: Array) -> Problem | None:
        if self.parameters.names != self.behind.parameters.names:
            return None
        held = self.behind.holding_inputs(x)
        return None if held is None else self.around(held)

    def with_phase_origin(self) -> Problem:
        return self.around(self.behind.with_phase_origin())

    def with_unbalance(self, position: float, magnitude: float, phase: float) -> Problem:
        return self.around(self.behind.with_unbalance(position, magnitude, phase))

    def with_unknown_unbalance(self, position: float, names: tuple[str, str], at_most: float) -> Problem:
        return self.around(self.behind.with_unknown_unbalance(position, names, at_most))

    def linearises_cheaply(self, loads: Sequence[Load] = ()) -> bool:
        """Whether the problem behind does, without loads.

        With loads it is False, as the derivative is then made of its own members.
        """
        return not loads and self.behind.linearises_cheaply()

    @property
    def unknown_impedances(self) -> tuple[UnknownImpedance, ...]:
        """Unknown impedances of the problem behind if unknowns and runs are the same, else empty."""
        same = self.parameters.names == self.behind.parameters.names and self.campaign == self.behind.campaign
        return self.behind.unknown_impedances if same else ()


def _handed_on(name: str) -> property:
    return property(lambda self: getattr(self.behind, name))


MADE_OF_OTHERS = ("response", "linearised", "response_and_per_load", "linearised_per_load")  # each proxy's own
HANDED_ON = tuple(
    name
    for name in (*Problem.__annotations__, *vars(Problem))
    if not (name.startswith("_") or name in vars(ProblemProxy) or name in MADE_OF_OTHERS)
)
for _name in HANDED_ON:
    setattr(ProblemProxy, _name, _handed_on(_name))
