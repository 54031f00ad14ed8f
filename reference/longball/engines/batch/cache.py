"""Compiled code, kept for later processes.

A file's name is a hash of everything that the code is made of: the sources of the modules, the
versions of the compilers, the processor. Changed sources lead to another file, so none is ever out
of date. A file that is not what was written is made anew.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
import tempfile
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import llvmlite
import numba
from llvmlite import binding
from numba.core import caching as untyped_caching
from numba.core import compiler as untyped_compiler
from numba.core import serialize as untyped_serialize

import longball
from longball.engines.compiled import folders

caching: Any = untyped_caching
compiler: Any = untyped_compiler
serialize: Any = untyped_serialize

F = TypeVar("F", bound=Callable[..., Any])

PACKAGE = Path(longball.__file__).parent
# What decides about the code: all of these files, and those in the folder of this one.
MODULES = (
    "engines/compiled.py",
    "engines/series.py",
    "model/law.py",
    "model/trace.py",
)

_NOTICE = "longball: compiling the batch engine (a few seconds, once per machine)"


@cache
def sources() -> tuple[str, ...]:
    """Return the sources of all modules that compiled code is made of."""
    files = sorted([*(PACKAGE / n for n in MODULES), *(PACKAGE / "engines/batch").glob("*.py")])
    return tuple(file.read_text(encoding="utf-8") for file in files)


@cache
def machine() -> tuple[str, ...]:
    """Return the compilers' versions and the processor that they compile for."""
    features = binding.get_host_cpu_features().flatten()
    return numba.__version__, llvmlite.__version__, binding.get_host_cpu_name(), features


def stored(name: str, made_of: Iterable[str], make: Callable[[], bytes]) -> bytes:
    """Return bytes that were kept under a name and what they are made of, or make and keep them."""
    key = hashlib.sha256("\0".join(made_of).encode()).hexdigest()[:24]
    kept = _read(f"{name}-{key}.bin")
    if kept is None:
        kept = make()
        _write(f"{name}-{key}.bin", kept)
    return kept


def _read(name: str) -> bytes | None:
    for folder in folders():
        try:
            whole = (folder / name).read_bytes()
        except OSError:
            continue
        checksum, content = whole[:32], whole[32:]
        if hashlib.sha256(content).digest() == checksum:
            return content
    return None


def _write(name: str, content: bytes) -> None:
    """Write a file at the first place that takes it, whole or not at all; maybe nowhere."""
    for folder in folders():
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=folder, delete=False) as file:
                file.write(hashlib.sha256(content).digest() + content)
            os.replace(file.name, folder / name)
            return
        except OSError:
            continue


@cache
def tell() -> None:
    """Say on standard error, once, that code is being compiled."""
    print(_NOTICE, file=sys.stderr, flush=True)


class _Cache(caching._Cache):  # type: ignore[misc]
    """What numba asks about compiled code, from `stored`."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.name = function.__name__.strip("_")

    @property
    def cache_path(self) -> str:
        return str(next(folders()))

    def _file(self, signature: Any) -> str:
        made_of = "\0".join([str(signature), *sources(), *machine()])
        return f"{self.name}-{hashlib.sha256(made_of.encode()).hexdigest()[:24]}.bin"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        content = _read(self._file(sig))
        if content is None:
            tell()
            return None
        target_context.refresh()
        return compiler.CompileResult._rebuild(target_context, *pickle.loads(content))

    def save_overload(self, sig: Any, data: Any) -> None:
        _write(self._file(sig), serialize.dumps(data._reduce()))

    def enable(self) -> None:
        """Do nothing: the cache is always on."""

    def disable(self) -> None:
        """Do nothing: the cache is always on."""

    def flush(self) -> None:
        """Do nothing: a file's name tells whether it is up to date."""


def compile_cached(function: F) -> F:
    """Compile a function at its first call, with all that it calls, for later processes too.

    The code is kept in the folder NUMBA_CACHE_DIR if that is set, else beside the package, or
    where that cannot be written to in the user's folder for such files.
    """
    dispatcher: Any = numba.njit(nogil=True, error_model="numpy")(function)
    dispatcher._cache = _Cache(function)
    return cast(F, dispatcher)
