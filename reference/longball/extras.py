"""Optional libraries, which extras such as ``pip install ".[fast]"`` install."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

EXTRAS = {
    "distributed": "dask",
    "joblib": "fast",
    "llvmlite": "fast",
    "matplotlib": "plot",
    "numba": "fast",
    "pandas": "tables",
    "pyarrow": "tables",
    "sympy": "symbolic",
}


_BROUGHT_BY = {"llvmlite": "numba"}


class MissingExtra(ImportError):
    """Raised if a library is not installed; the message says how to install it."""


@contextmanager
def naming_extras() -> Iterator[None]:
    """Raise a `MissingExtra` if a library of an extra is not installed; also as a decorator."""
    try:
        yield
    except ModuleNotFoundError as error:
        library = (error.name or "").partition(".")[0]
        if library not in EXTRAS:
            raise
        needed, extra = _BROUGHT_BY.get(library, library), EXTRAS[library]
        raise MissingExtra(f'this needs {needed}: pip install ".[{extra}]"', name=library) from None
