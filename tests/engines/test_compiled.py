"""Compiled code that is kept for later processes: never out of date, never trusted when damaged."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from longball.engines import compiled

DAMAGES: list[Callable[[bytes], bytes]] = [
    lambda whole: b"",
    lambda whole: whole[:50],
    lambda whole: whole[:-1],
    lambda whole: whole[:40] + bytes([whole[40] ^ 1]) + whole[41:],
    lambda whole: bytes(len(whole)),
]


def test_a_change_of_any_source_changes_the_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "longball"
    shutil.copytree(compiled.PACKAGE, package, ignore=shutil.ignore_patterns("data", "__pycache__"))
    monkeypatch.setattr(compiled, "PACKAGE", package)
    read = compiled.sources.__wrapped__
    before = read()
    files = [file for pattern in compiled.SOURCES for file in package.glob(pattern)]
    assert len(files) > len(compiled.SOURCES)
    for file in files:
        text = file.read_text()
        file.write_text(text + "#\n")
        assert read() != before, file
        file.write_text(text)
    assert read() == before


def test_every_module_with_compiled_functions_is_among_the_sources() -> None:
    sources = {file for pattern in compiled.SOURCES for file in compiled.PACKAGE.glob(pattern)}
    decorated = {
        file
        for file in compiled.PACKAGE.rglob("*.py")
        if file.parent.name != "__pycache__"  # which is where printed modules may be kept
        if "\n@compiled\n" in file.read_text() or "\n@inner\n" in file.read_text()
    }
    assert decorated
    assert decorated <= sources


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    return tmp_path


def test_code_is_kept_and_made_anew_when_its_file_is_not_what_was_written(folder: Path) -> None:
    made: list[int] = []

    def make() -> bytes:
        made.append(1)
        return b"code" * 100

    assert compiled.stored("law", ["a"], make) == compiled.stored("law", ["a"], make)
    assert len(made) == 1
    (file,) = folder.iterdir()
    for count, damage in enumerate(DAMAGES, 2):
        file.write_bytes(damage(file.read_bytes()))
        assert compiled.stored("law", ["a"], make) == b"code" * 100
        assert len(made) == count
    compiled.stored("law", ["b"], make)
    assert len(made) == len(DAMAGES) + 2


def test_a_compiled_function_is_kept(folder: Path) -> None:
    def fresh() -> Callable[[float], float]:
        def twice(x: float) -> float:
            return 2.0 * x

        return compiled.compiled(twice)

    def hits(function: Callable[[float], float]) -> int:
        assert function(3.0) == 6.0
        return sum(function._cache_hits.values())  # type: ignore[attr-defined]

    assert [hits(fresh()), hits(fresh())] == [0, 1]
    (file,) = folder.iterdir()
    for damage in DAMAGES:
        file.write_bytes(damage(file.read_bytes()))
        assert [hits(fresh()), hits(fresh())] == [0, 1]


SOURCE = """
def twice(x):
    return 2.0 * x

def total(xs):
    s = 0.0
    for i in range(len(xs)):
        s += twice(xs[i])
    return s
"""


def test_so_are_those_of_a_module(folder: Path) -> None:
    for hits in (0, 1):
        module = compiled._made.__wrapped__(SOURCE, True)
        assert module.total(np.array([3.0, 4.0])) == 14.0
        assert sum(module.total._cache_hits.values()) == hits
    other = compiled._made(SOURCE.replace("2.0", "3.0"), True)
    assert other.total(np.array([3.0])) == 9.0
    assert len(list(folder.iterdir())) == 4


def test_code_runs_as_it_is_until_it_has_worked_enough(folder: Path) -> None:
    code = compiled.Code(SOURCE + "\n\n", 10)
    for _ in range(5):
        run = code.count(2)
        assert run is code.now
        assert run.total(run.taken(np.array([3.0, 4.0]))) == 14.0
        assert not list(folder.iterdir())
    run = code.count()
    assert run.total(run.taken(np.array([3.0, 4.0]))) == 14.0
    assert len(list(folder.iterdir())) == 2
    assert code.count() is run


def test_without_numba_code_runs_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.setattr(compiled, "compiler", compiled.compiler.__wrapped__)
    code = compiled.Code(SOURCE + "\n\n\n", 0)
    assert code.count() is code.now
    assert code.now.total(code.now.taken(np.array([3.0, 4.0]))) == 14.0


def test_what_is_timed_is_compiled_at_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "_HASTE", 1.0)
    compiled.compile_at_once()
    run = compiled.Code(SOURCE + "\n", 10).count()
    assert run.total(np.array([3.0])) == 6.0
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize(
    ("variables", "last"),
    [
        ({"NUMBA_CACHE_DIR": "/chosen", "HOME": "/home/a"}, "/chosen"),
        ({"LOCALAPPDATA": "/local", "XDG_CACHE_HOME": "/cache"}, "/local/longball"),
        ({"XDG_CACHE_HOME": "/cache", "HOME": "/home/a"}, "/cache/longball"),
        ({"HOME": "/home/a"}, "/home/a/.cache/longball"),
        ({"XDG_CACHE_HOME": "nowhere"}, None),
    ],
)
def test_where_code_is_kept(
    variables: dict[str, str], last: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("NUMBA_CACHE_DIR", "LOCALAPPDATA", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    with_package = [] if "NUMBA_CACHE_DIR" in variables else [Path(compiled.__file__).parent]
    places = [folder / "__pycache__" for folder in with_package]
    assert list(compiled.folders()) == places + ([Path(last)] if last else [])


def test_a_folder_that_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    assert compiled.stored("law", ["a"], lambda: b"code") == b"code"
    assert compiled.compiled(lambda x: x + 1.0)(1.0) == 2.0


def test_a_disk_that_is_full_leaves_no_halves(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*arguments: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    assert compiled.stored("law", ["a"], lambda: b"code") == b"code"
    assert list(folder.iterdir()) == []


def test_neither_package_nor_home_can_be_written_to(tmp_path: Path) -> None:
    """Files in place of the folders close these to all users, root included."""
    package = tmp_path / "longball"
    package.mkdir()
    for part in compiled.PACKAGE.iterdir():
        if part.name not in ("engines", "__pycache__"):
            (package / part.name).symlink_to(part)
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(compiled.PACKAGE / "engines", package / "engines", ignore=ignored)
    (package / "engines" / "__pycache__").touch()
    (tmp_path / "home").touch()
    code = """
import sys
from longball.cli import app
from longball.engines import compiled
from longball.judge import assert_case, cases
assert compiled.__file__.startswith(sys.argv[1]), compiled.__file__
assert_case(cases("flight-vacuum")[0], cases("flight-vacuum")[0].expected)
open(sys.argv[2], "w").write('{"id": "a", "kind": "at-bat"}')
app(["solve", "--engine", "verlet", sys.argv[2]], standalone_mode=False)
"""
    environment = {**os.environ, "HOME": str(tmp_path / "home"), "PYTHONPATH": str(tmp_path)}
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        environment.pop(name, None)
    run = subprocess.run(
        [sys.executable, "-B", "-c", code, str(tmp_path), str(tmp_path / "scene.jsonl")],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert json.loads(run.stdout)["outcome"] == "missed"
    assert run.stderr == ""
