"""The kinds of arrays that numbers and indices travel in."""
# Shorter than 40 lines: types that every module uses.

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
