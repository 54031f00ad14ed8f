"""Compiled functions, by numba where it is installed; without it they run as they are, slowly.

Compiled code is kept on disk for later processes: beside the module, or where that cannot be
written to in the user's cache, or in the folder that NUMBA_CACHE_DIR names.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, cast

numba: Any
try:
    numba = importlib.import_module("numba")
except ImportError:
    numba = None

COMPILES = numba is not None

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile a function at its first call, and keep the code if there is a place for it.

    The code is made anew when the function's own file changes, and so that file defines or prints
    all that the function calls. Division by zero gives inf or nan where it is compiled.
    """
    if not COMPILES:
        return function
    settings = {"nogil": True, "error_model": "numpy"}
    try:
        return cast(F, numba.njit(cache=True, **settings)(function))
    except (OSError, RuntimeError):  # no file, or no place to write: compile in each process
        return cast(F, numba.njit(**settings)(function))


@cache
def module_of(source: str) -> ModuleType:
    """Return printed code as a module.

    numba keeps code by the file that it comes from. A printed module is written into one that has
    the hash of its text in its name, so that other text is never taken for it.
    """
    name = f"printed_{hashlib.sha256(source.encode()).hexdigest()[:16]}"
    file = _written(name, source) if COMPILES else None
    module = ModuleType(name)
    if file is not None:
        spec = importlib.util.spec_from_file_location(name, file)
        assert spec is not None
        module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # where numba looks for the globals of code that was kept
    exec(compile(source, str(file or "<printed>"), "exec"), module.__dict__)
    return module


def _written(name: str, source: str) -> Path | None:
    for folder in folders():
        file = folder / f"{name}.py"
        try:
            if not file.exists() or file.read_text() != source:
                folder.mkdir(parents=True, exist_ok=True)
                with tempfile.NamedTemporaryFile("w", dir=folder, delete=False) as draft:
                    draft.write(source)
                os.replace(draft.name, file)
        except OSError:
            continue
        return file
    return None


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
