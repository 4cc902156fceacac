"""Forwarded names of the module that was `ksmea.settings`, for one release.

They come from `ksmea.settings.settings`. Shorter than 40 lines: it only forwards.
"""

from typing import Any


def __getattr__(name: str) -> Any:
    import ksmea.settings.settings as module

    if name.startswith("__") or not hasattr(module, name):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from ksmea.errors import warn_moved

    warn_moved(f"{__name__}.{name}", module.__name__)
    return getattr(module, name)
