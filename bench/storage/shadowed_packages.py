"""Whether something in the working directory stands in front of this project's packages.

`python -m bench` looks for modules in the working directory first, so that a `problems.py` there would be imported in
place of the project's own. The console command looks elsewhere.
"""
# Shorter than 40 lines: it is imported before anything else.

from __future__ import annotations

import importlib.util
from pathlib import Path

PACKAGES = ("hydra_plugins", "ksmea", "measurements", "optimizers", "problems", "surrogates")
HOME = Path(__file__).resolve().parents[2]  # where all packages of this project lie side by side
COMMAND = "ksmea-bench"


def hidden() -> str | None:
    """One line on the first package that is hidden; None if all are the project's own."""
    for name in PACKAGES:
        spec = importlib.util.find_spec(name)
        places = [] if spec is None else [*(spec.submodule_search_locations or ()), spec.origin]
        if not any(place and Path(place).resolve().is_relative_to(HOME / name) for place in places):
            found = next((place for place in places if place), "nothing")
            return (
                f"{name}: expected this project's package, found {found}; give the command `{COMMAND}` in place of"
                " `python -m bench`, or work in another directory"
            )
    return None
