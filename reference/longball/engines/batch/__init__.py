"""The batch engine: Taylor series, compiled, for one scene or for millions, with the same bits.

`lanes` gives compiled code values of sixteen doubles; `expansion` has the series of sixteen
flights; `roots` finds the events on a step's polynomials; `flights` flies records to their ends.
`engine` makes an engine of it, for one scene at a time; `chain` is the at-bat over columns, and
`many` what one calls.
"""

from longball.engines.batch.engine import Batch
from longball.engines.batch.many import (
    solve_all,
    solve_columns,
    solve_columns_with_restitutions,
)

__all__ = ["Batch", "solve_all", "solve_columns", "solve_columns_with_restitutions"]
