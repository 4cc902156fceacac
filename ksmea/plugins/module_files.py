"""Files of modules, found as Python would find them, without importing anything.

Shorter than 40 lines: it does one thing.

`importlib.util.find_spec("a.b")` imports `a`, which runs its code. Names may come from a received folder of results, whose code must
not run, and completion must not wait for packages that are slow to import. So a package's folders are taken from where it is
found, not from the imported package. Folders that a package adds to its path while it is imported are not seen.
"""

from __future__ import annotations

from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from pathlib import Path


def module_spec(name: str) -> ModuleSpec | None:
    """Specification of a module as Python finds it; None if it finds none.

    The packages that the module lies in are not imported for that.

    >>> module_spec("email.mime.text").origin.endswith("text.py"), module_spec("email.no_such") is None
    (True, True)
    """
    top, *below = name.split(".")
    try:
        spec = find_spec(top)
    except (ImportError, AttributeError, ValueError):  # no name of a module, or one that was made by hand
        return None
    for number in range(len(below)):
        places = None if spec is None else spec.submodule_search_locations
        full_name = ".".join([top, *below[: number + 1]])
        spec = None if places is None else PathFinder.find_spec(full_name, places)
    return spec


def source_file(name: str) -> Path | None:
    """The file of a module; None if it has none of Python source."""
    spec = module_spec(name)
    return Path(spec.origin) if spec is not None and spec.origin and spec.origin.endswith(".py") else None
