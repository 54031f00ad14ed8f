"""The batch engine: Taylor series, compiled, for one scene or for millions, with the same bits.

`writer` writes machine code on sixteen lanes. Of a law `expansion` makes a step, a Taylor series,
and `tangents` its derivatives; `flights` flies records to their ends, whose events `roots` finds on
a step's polynomials, in code that `jit` helps to compile.
`records` writes and reads the records; `columns` gives the chain columns for numbers, `slopes`
columns with derivatives; `many` has the engine and the functions for columns.
"""

from longball.engines.batch.many import Batch as Batch
from longball.engines.batch.many import solve_columns as solve_columns
from longball.engines.batch.many import (
    solve_columns_with_restitutions as solve_columns_with_restitutions,
)
from longball.engines.batch.many import solve_columns_with_slopes as solve_columns_with_slopes
from longball.engines.batch.many import solve_decided_columns as solve_decided_columns
