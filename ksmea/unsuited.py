"""What a surrogate raises that cannot follow the response."""

from __future__ import annotations

from ksmea.contracts import Surrogate


class Unsuited(ArithmeticError):
    """Raised by the fit of a surrogate where samples show that it cannot follow the response: `substitute` takes over; None: the
    run ends with the message."""

    def __init__(self, message: str, substitute: Surrogate | None = None) -> None:
        super().__init__(message)
        self.substitute = substitute
