"""Old path of `ksmea.problem.alignment`, for one release. Shorter than 40 lines: it only forwards."""

from ksmea.errors import warn_moved
from ksmea.problem.alignment import *

warn_moved(__name__, "ksmea.problem.alignment")
