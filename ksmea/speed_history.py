"""How the speed of a machine went while a run was measured, as far as the record of it tells."""

from __future__ import annotations

from dataclasses import dataclass

ACCELERATION = "acceleration"  # the unknown that is the rate of a sweep
DIRECTIONS = ("run-up", "coast-down")
CONSTANT = 0.2  # of the mean rate, by which the rates of the two halves of a run may differ


@dataclass(frozen=True)
class SpeedHistory:
    """`direction` is one of `DIRECTIONS`, or "either" where speeds are in order and nothing says which way. `rates` are those of
    the first and the second half of the run (rad/s²): from times, or if each row were a turn of the shaft; None: nothing tells."""

    direction: str
    rates: tuple[float, float] | None = None
    from_times: bool = False

    @property
    def rate(self) -> float | None:
        """The mean rate, rad/s², negative in a coast-down."""
        return None if self.rates is None else sum(self.rates) / 2

    @property
    def is_constant(self) -> bool:
        """Whether the rate is known, and the same in both halves."""
        if self.rates is None or self.rate is None:
            return False
        return abs(self.rates[1] - self.rates[0]) <= CONSTANT * abs(self.rate)
