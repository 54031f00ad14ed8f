"""The golden data: scenes with proven results, to test other implementations with.

>>> from longball import golden
>>> case = golden.load("at-bat")[0]
>>> case.scene, case.expected, case.flags, case.attainable("landing.distance")
>>> row = golden.probabilities().cases[0].rows[0]
>>> row.e, row.p, row.error, row.slope, row.slope_error

Reading needs none of the libraries that made the data. `longball.golden.writer` makes it,
`longball.golden.checker` verifies it.
"""

from longball.golden.case import Case, Header, Probabilities
from longball.golden.reader import header, load, probabilities

__all__ = ["Case", "Header", "Probabilities", "header", "load", "probabilities"]
