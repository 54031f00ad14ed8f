"""Functions compiled by numba; without numba they run as Python, slowly.

Compiling a function takes seconds, and loading numba with cached code about one second. A single
scene takes milliseconds as Python. Code generated for a law therefore runs as Python until it has
worked enough (`Code`), with the same results to the last bit.

Compiled code is cached on disk: in the folder NUMBA_CACHE_DIR, else next to this module, or, if
that is not writable, in the user's cache; otherwise each process compiles again. The name of a file
is a hash of everything that the code depends on: sources, versions of the compilers, processor.
Changed sources give another name, so that no file is out of date. A damaged file is replaced.

numba's own cache (``cache=True``) would need less code, but it checks only the age of the file with
the function: if a called function in another file changes, the old code is used. A damaged file
ends in an error of LLVM. Generated code has no file at all.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import math
import os
import pickle
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast

import numpy as np

import longball

F = TypeVar("F", bound=Callable[..., Any])

# Exceptions of arithmetic in Python, where compiled code returns inf or nan.
BEYOND = (ArithmeticError, ValueError)

PACKAGE = Path(longball.__file__).parent
# Sources of compiled code. Generated modules are not here: their names are hashes of their text.
SOURCES = (
    "engines/batch/*.py",
    "engines/compiled.py",
    "engines/series.py",
    "model/law.py",
    "model/trace.py",
)


@cache
def compiler() -> Any:
    """Return numba; None if it is not installed."""
    try:
        return importlib.import_module("numba")
    except ImportError:
        return None


def compiled(function: F) -> F:
    """Compile a function at its first call, with all functions that it calls, and cache the code.

    In compiled code, a division by zero gives inf or nan.
    """
    if compiler() is None:
        return function
    dispatcher = compiler().njit(nogil=True, error_model="numpy")(function)
    dispatcher._cache = _Cache(function)
    return cast(F, dispatcher)


# Factor on the counted work; infinity means: compile at the first call.
_HASTE = 1.0  # a free choice


def compile_at_once() -> None:
    """Compile all code at its first use from now on, for benchmarks."""
    global _HASTE
    _HASTE = math.inf


class Code:
    """Generated functions that run as Python at first, and compiled after enough work."""

    def __init__(
        self,
        # Source of a module, whose functions call no others.
        source: str,
        enough: int,  # work, in the units of `count`, that takes as long as compiling
    ) -> None:
        self._source, self._left = source, float(enough)
        # The module with the current functions. Its `taken` converts an array to their argument: a
        # list of numbers for Python (faster there), the array itself for compiled code.
        self.now = _made(source, False)

    def count(self, work: int = 1) -> ModuleType:
        """Count work, and return the module with the current functions."""
        if self._left >= 0:
            self._left -= _HASTE * work
            if self._left < 0 and compiler() is not None:
                self.now = _made(self._source, True)
        return self.now


@cache
def _made(source: str, compile_all: bool) -> ModuleType:
    """Return the module of a source, with its functions as they are or compiled."""
    kind = "compiled" if compile_all else "printed"
    name = f"{kind}_{hashlib.sha256(source.encode()).hexdigest()[:16]}"
    module = ModuleType(name)
    # numba looks up the globals of cached code here.
    sys.modules[name] = module
    exec(compile(source, f"<{name}>", "exec"), module.__dict__)
    for key, value in vars(module).copy().items():
        if compile_all and isinstance(value, FunctionType) and value.__module__ == name:
            vars(module)[key] = compiled(value)
    vars(module)["taken"] = np.asarray if compile_all else np.ndarray.tolist
    return module


class _Cache:
    """Cache of compiled code, as numba asks for it."""

    def __init__(self, function: Callable[..., Any]) -> None:
        code = function.__code__
        self._name = code.co_name.strip("_")
        self._made_of = f"{function.__module__} {code.co_qualname} {code.co_firstlineno}"

    def _file(self, signature: Any) -> str:
        return _file_name(self._name, [self._made_of, str(signature)])

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        content = _read(self._file(signature))
        if content is None:
            return None
        target_context.refresh()
        rebuild = compiler().core.compiler.CompileResult._rebuild
        return rebuild(target_context, *pickle.loads(content))

    def save_overload(self, signature: Any, result: Any) -> None:
        _write(self._file(signature), compiler().core.serialize.dumps(result._reduce()))


def stored(name: str, made_of: Iterable[str], make: Callable[[], bytes]) -> bytes:
    """Return cached code, or make and cache it; the key is a name and `made_of`."""
    file = _file_name(name, made_of)
    kept = _read(file)
    if kept is None:
        kept = make()
        _write(file, kept)
    return kept


def _file_name(name: str, made_of: Iterable[str]) -> str:
    key = "\0".join([*made_of, *sources(), *machine()])
    return f"{name}-{hashlib.sha256(key.encode()).hexdigest()[:24]}.bin"


@cache
def sources() -> tuple[str, ...]:
    """Return the sources of all modules that compiled code depends on."""
    files = (file for pattern in SOURCES for file in sorted(PACKAGE.glob(pattern)))
    return tuple(file.read_text(encoding="utf-8") for file in files)


@cache
def machine() -> tuple[str, ...]:
    """Return the versions of Python and the compilers, and the processor."""
    from llvmlite import __version__, binding

    features = binding.get_host_cpu_features().flatten()
    return sys.version, compiler().__version__, __version__, binding.get_host_cpu_name(), features


# --- files ----------------------------------------------------------------------------------------


def folders() -> Iterator[Path]:
    """Yield the folders for compiled code, the best one first."""
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(chosen)
        return
    yield Path(__file__).parent / "__pycache__"
    user = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_CACHE_HOME")
    user = user or os.path.expanduser("~/.cache")
    if os.path.isabs(user):  # there are users without a home
        yield Path(user, "longball")


def _read(name: str) -> bytes | None:
    """Load compiled code; without any, announce the compilation and return None."""
    for folder in folders():
        try:
            whole = (folder / name).read_bytes()
        except OSError:
            continue
        # The file begins with its checksum: a damaged one counts as missing.
        checksum, content = whole[:32], whole[32:]
        if hashlib.sha256(content).digest() == checksum:
            return content
    _announce_compilation()
    return None


def _write(name: str, content: bytes) -> None:
    """Write a file atomically into the first writable folder, if there is one."""
    for folder in folders():
        draft = folder / f"{name}.{os.getpid()}.{threading.get_ident()}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            draft.write_bytes(hashlib.sha256(content).digest() + content)
            os.replace(draft, folder / name)
            return
        except OSError:
            with contextlib.suppress(OSError):
                draft.unlink()


@cache
def _announce_compilation() -> None:
    """Print a note on the first compilation; on terminals only."""
    if sys.stderr is not None and sys.stderr.isatty():
        print("longball: compiling (a few seconds, once per machine)", file=sys.stderr)
