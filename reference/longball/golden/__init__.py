"""The golden data: scenes with proven results, for anybody to hold an implementation against.

>>> from longball import golden
>>> case = golden.load("at-bat")[0]
>>> case.scene, case.expected, case.flags, case.attainable("landing.distance")

Reading needs none of the libraries that made the data. `longball.golden.writer` makes it,
`longball.golden.checker` verifies it.
"""

from longball.golden.case import Case, Header
from longball.golden.reader import header, load

__all__ = ["Case", "Header", "header", "load"]
