"""Old path of `ksmea.measurement.channel`, for one release. Shorter than 40 lines: it only forwards."""

from ksmea.errors import warn_moved
from ksmea.measurement.channel import *

warn_moved(__name__, "ksmea.measurement.channel")
