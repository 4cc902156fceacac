"""Old path of `ksmea.plugins.registry`, for one release. Shorter than 40 lines: it only forwards."""

from ksmea.errors import warn_moved
from ksmea.plugins.registry import *

warn_moved(__name__, "ksmea.plugins.registry")
