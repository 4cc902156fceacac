"""Old path of names in `ksmea.plugins.surrogate`, for one release.

Shorter than 40 lines: it only forwards.
"""

from ksmea.errors import warn_moved
from ksmea.plugins.surrogate import Unsuited

__all__ = ["Unsuited"]

warn_moved(__name__, "ksmea.plugins.surrogate")
