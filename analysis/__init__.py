"""Longball's own studies: `python -m analysis [STUDY ...]` writes them into report/."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
