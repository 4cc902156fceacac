"""Printed text on streams that lack some of its characters: a Windows pipe (cp1252), ASCII, Latin-1.

Nothing that is printed may fail for its characters. A sign that the stream's encoding lacks is written in plain ones: `→` as `->`, `Δ` as
`Delta`, `10⁻³` as `10^-3`. Any other one is written as its escape, also the half of a surrogate pair that stands for a byte of a
file's name.
"""

from __future__ import annotations

import codecs
import sys
import unicodedata

NAME = "bench_plain_signs"  # of the error handler
SIGNS = {
    "–": "-",
    "—": "-",
    "−": "-",
    "→": "->",
    "←": "<-",
    "≤": "<=",
    "≥": ">=",
    "≈": "~",
    "∝": "~",
    "±": "+/-",
    "∓": "-/+",
    "×": "x",
    "·": "*",
    "°": " deg",
    "µ": "u",
    "μ": "u",
    "√": "sqrt",
    "∞": "inf",
    "∂": "d",
    "∫": "integral ",
    "′": "'",
    "″": '"',
    "‖": "||",
    "●": "*",
    "§": "section ",
    "ø": "o",
    "Ø": "O",
    "ß": "ss",
    "‘": "'",
    "’": "'",
    "“": '"',
    "”": '"',
    "⁄": "/",
    "\N{NO-BREAK SPACE}": " ",
}
RAISED = "SUPERSCRIPT"
GREEK = {"GREEK SMALL LETTER ": str.lower, "GREEK CAPITAL LETTER ": str.capitalize}


def print_any_sign() -> None:
    """Let the streams of this process take any text."""
    codecs.register_error(NAME, _replaced)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)  # a notebook's or a test's stream may have none
        if reconfigure is not None:
            reconfigure(errors=NAME)


def in_plain_signs(text: str) -> str:
    r"""A text in ASCII.

    >>> in_plain_signs("Δk ≤ 10⁻³ m², ½ µm"), in_plain_signs("\udce4\u2603")
    ('Deltak <= 10^-3 m^2, 1/2 um', '\\udce4\\u2603')
    """
    return "".join(sign if sign.isascii() else _plain(sign, before) for before, sign in zip(["", *text], text))


def _plain(sign: str, before: str) -> str:
    if sign in SIGNS:
        return SIGNS[sign]
    name = unicodedata.name(sign, "")
    for letter, written in GREEK.items():
        if name.startswith(letter) and " " not in (own := name.removeprefix(letter)):
            return written(own.replace("LAMDA", "LAMBDA"))
    parts = "".join(SIGNS.get(each, each) for each in unicodedata.normalize("NFKD", sign))
    letters = "".join(each for each in parts if each.isascii())
    if letters:
        is_next = RAISED in name and RAISED in unicodedata.name(before or " ", "")
        is_raised = RAISED in name and not is_next
        is_part = "FRACTION" in name and before.isdigit()  # 2½ is 2 1/2
        return f"^{letters}" if is_raised else f" {letters}" if is_part else letters
    if unicodedata.combining(sign):
        return ""
    return sign.encode("unicode_escape").decode()


def _replaced(error: UnicodeError) -> tuple[str, int]:
    """Replacement of the signs that an encoding lacks, for its encoder."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    before = error.object[max(error.start - 1, 0) : error.start]
    text = error.object[error.start : error.end]
    return "".join(map(_plain, text, [before, *text])), error.end
