"""Old path of `ksmea.numerics.objective`, for one release. Shorter than 40 lines: it only forwards."""

from ksmea.errors import warn_moved
from ksmea.numerics.objective import *

warn_moved(__name__, "ksmea.numerics.objective")
