"""Declarations of the package: versions, constraints, extras."""

from __future__ import annotations

import re
import runpy
import tomllib
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from longball.extras import EXTRAS

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
# Those are for `make bench`, and installed by hand.
UNCONSTRAINED = {"peers"}


def needed(texts: list[str], extras: frozenset[str], found: set[str]) -> set[str]:
    """Collect the names of all distributions that requirements lead to."""
    for text in texts:
        requirement = Requirement(text)
        name = canonicalize_name(requirement.name)
        marker = requirement.marker
        if marker and not any(marker.evaluate({"extra": extra}) for extra in extras | {""}):
            continue
        key = f"{name}[{','.join(sorted(requirement.extras))}]"
        if key in found:
            continue
        found.add(key)
        try:
            requires = distribution(name).requires or []
        except PackageNotFoundError:  # not for this Python, or of an extra that is not installed
            continue
        needed(requires, frozenset(requirement.extras), found)
    return found


def test_constraints_are_complete():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line.partition("==")[0] for line in lines if not line.startswith("#")]
    assert pins == sorted(pins, key=str.lower)
    extras = PROJECT["optional-dependencies"]
    roots = PROJECT["dependencies"] + [
        text for extra, texts in extras.items() if extra not in UNCONSTRAINED for text in texts
    ]
    found = {key.partition("[")[0] for key in needed(roots, frozenset(), set())}
    assert found - {canonicalize_name(pin) for pin in pins} == {"longball"}


def test_extras_are_those_that_are_named_to_users():
    declared = {
        canonicalize_name(Requirement(text).name): extra
        for extra in set(EXTRAS.values())
        for text in PROJECT["optional-dependencies"][extra]
    }
    named = {name: extra for name, extra in EXTRAS.items() if name != "llvmlite"}  # numba brings it
    assert declared == named | {"longball": "dask"}
    light = {canonicalize_name(Requirement(text).name) for text in PROJECT["dependencies"]}
    assert light == {
        *("jinja2", "mpmath", "numpy", "pydantic"),
        *("python-flint", "rich", "scipy", "typer"),
    }


def test_versions_and_dates_agree():
    faults = runpy.run_path(str(ROOT / ".ci" / "release.py"))["faults"]
    assert faults() == []
    assert any("the tag is v0" in fault for fault in faults("v0"))


def test_python_versions_agree():
    declared = re.findall(r"Python :: (3\.\d+)", "\n".join(PROJECT["classifiers"]))
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    for matrix in re.findall(r"python: \[(.*)\]", workflow):
        assert re.findall(r"[\d.]+", matrix) == declared
    assert PROJECT["requires-python"] == f">={declared[0]}"
