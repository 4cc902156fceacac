"""Names of files and folders made of names of methods and problems."""

from __future__ import annotations

import re
from collections.abc import Iterable


def file_name(text: str) -> str:
    """The letters and digits of a text.

    >>> file_name("Kriging + DE"), file_name("../CMA-ES")
    ('Kriging_DE', 'CMA-ES')
    """
    return re.sub(r"[^A-Za-z0-9-]+", "_", text).strip("_") or "unnamed"


def file_names(texts: Iterable[str]) -> dict[str, str]:
    """The same for several, with a number where two would be alike.

    >>> file_names(["Kriging + DE", "Kriging, DE"])
    {'Kriging + DE': 'Kriging_DE', 'Kriging, DE': 'Kriging_DE_2'}
    """
    found: dict[str, str] = {}
    for text in texts:
        name, number = file_name(text), 1
        while name in found.values():
            number += 1
            name = f"{file_name(text)}_{number}"
        found[text] = name
    return found
