"""Compiled functions, by numba where it is installed; without it they run as they are, slowly.

To compile a function takes seconds, to load numba and what was compiled about one. A single scene
needs milliseconds without. Code that is printed for a law therefore runs as it is until it has
worked enough (`Code`), with the same results to the last bit.

Compiled code is kept on disk for later processes: in the folder that NUMBA_CACHE_DIR names, else
beside this module, or where that cannot be written to in the user's cache; where there is no such
place, each process compiles for itself. A file's name is a hash of all that the code is made of:
sources, versions of the compilers, processor. Changed sources lead to another file, so none is ever
out of date. A file that is not what was written is made anew.

numba's own cache (``cache=True``) would be less code, but keeps neither promise. It looks at the
age of the file that a function stands in alone, so that code stays as it was when a function that
it calls is changed in another file; a damaged file ends in LLVM's error. Of printed code there is
no file at all.
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

# What arithmetic raises in code that runs as it is, where compiled code gives inf or nan.
BEYOND = (ArithmeticError, ValueError)

PACKAGE = Path(longball.__file__).parent
# What compiled code is made of, but for printed modules, whose names are hashes of their text.
SOURCES = (
    "engines/batch/*.py",
    "engines/compiled.py",
    "engines/series.py",
    "engines/variation.py",
    "model/law.py",
    "model/trace.py",
)


@cache
def compiler() -> Any:
    """Return numba; None where it is not installed."""
    try:
        return importlib.import_module("numba")
    except ImportError:
        return None


def compiled(function: F) -> F:
    """Compile a function at its first call, with all that it calls, for later processes too.

    Division by zero gives inf or nan where it is compiled.
    """
    if compiler() is None:
        return function
    dispatcher = compiler().njit(nogil=True, error_model="numpy")(function)
    dispatcher._cache = _Cache(function)
    return cast(F, dispatcher)


_HASTE = 1.0


def compile_at_once() -> None:
    """Compile all code at its first use from now on, as what is timed should be."""
    global _HASTE
    _HASTE = math.inf


class Code:
    """Functions that run as they are at first, and compiled from when that is worth its time."""

    def __init__(
        self,
        # Of a module: its functions call each other, and nothing else to be compiled
        source: str,
        enough: int,  # units of work, as `count` has them, that take as long as compiling
    ) -> None:
        self._source, self._left = source, float(enough)
        # A module of the functions as they run now, and `taken`, which makes an array what they
        # take: a list of numbers, or the array itself where they are compiled.
        self.now = _as_it_is(source)

    def count(self, work: int = 1) -> ModuleType:
        """Return the functions for some more work."""
        if self._left >= 0:
            self._left -= _HASTE * work
            if self._left < 0 and compiler() is not None:
                self.now = _compiled(self._source)
        return self.now


def _module(source: str, kind: str) -> ModuleType:
    name = f"{kind}_{hashlib.sha256(source.encode()).hexdigest()[:16]}"
    module = ModuleType(name)
    sys.modules[name] = module  # where numba looks for the globals of code that was kept
    exec(compile(source, f"<{name}>", "exec"), module.__dict__)
    return module


@cache
def _as_it_is(source: str) -> ModuleType:
    module = _module(source, "printed")
    vars(module)["taken"] = np.ndarray.tolist
    return module


@cache
def _compiled(source: str) -> ModuleType:
    module = _module(source, "compiled")
    for name, value in vars(module).copy().items():
        if isinstance(value, FunctionType) and value.__module__ == module.__name__:
            vars(module)[name] = compiled(value)
    vars(module)["taken"] = np.asarray
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
    """Return code that was kept under a name and what else it is made of, or make and keep it."""
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
    """Return the sources of all modules that compiled code is made of."""
    files = (file for pattern in SOURCES for file in sorted(PACKAGE.glob(pattern)))
    return tuple(file.read_text(encoding="utf-8") for file in files)


@cache
def machine() -> tuple[str, ...]:
    """Return the versions of Python and the compilers, and the processor that they compile for."""
    from llvmlite import __version__, binding

    features = binding.get_host_cpu_features().flatten()
    return sys.version, compiler().__version__, __version__, binding.get_host_cpu_name(), features


# --- files ----------------------------------------------------------------------------------------


def folders() -> Iterator[Path]:
    """Yield where compiled code may be kept, the best place first."""
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
        checksum, content = whole[:32], whole[32:]
        if hashlib.sha256(content).digest() == checksum:
            return content
    _announce_compilation()
    return None


def _write(name: str, content: bytes) -> None:
    """Write a file at the first place that takes it, whole or not at all; maybe nowhere."""
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
        print("longball: compiling (a few seconds, once per machine)", file=sys.stderr, flush=True)
