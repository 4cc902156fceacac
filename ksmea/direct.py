"""Old path of `ksmea.identification.direct`, for one release. Shorter than 40 lines: it only forwards."""

from ksmea.errors import warn_moved
from ksmea.identification.direct import *

warn_moved(__name__, "ksmea.identification.direct")
