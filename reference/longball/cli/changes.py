"""Options that change scenes: --set, --fence, --reading."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from longball.cli.messages import refusing, split_assignment, wrong_call
from longball.model.changes import Changes, changes_of, value_of
from longball.model.jsonl import json_or_number
from longball.model.names import one_of
from longball.model.readings import LEDGER, SCHEME_OPTIONS, Belongs
from longball.model.units import UNITS, read_in_si


def chosen_changes(
    values: Sequence[str] | None,
    fence: str | None,
    readings: Sequence[str] | None = None,
    blocks: Mapping[str, Any] | None = None,
) -> Changes:
    """Collect the options that change scenes; a sampling or scheme reading is a usage error.

    `blocks` come first, so that the options change them.
    """
    # Only those of the scene can change scenes; the others belong to homerun and verlet.
    switches = chosen_switches(readings or [])
    for belongs, named in switches.items():
        if belongs != "scene" and named:
            wrong_call(f"--reading {next(iter(named))}: it changes no scene, but longball homerun")
    whole = {**(blocks or {})}
    whole |= {f"reading.{name}": option for name, option in switches["scene"].items()}
    if fence is not None:
        whole["fence"] = fence_block(fence)
    with refusing("--set "):
        return changes_of((split_assignment("--set", text) for text in values or []), whole)


def chosen_switches(readings: Sequence[str]) -> dict[Belongs, dict[str, Any]]:
    """Return the switches that options set, by what they belong to."""
    ledger = {entry.switch: entry for entry in LEDGER if entry.is_switch}
    switches: dict[Belongs, dict[str, Any]] = {"scene": {}, "sampling": {}, "figure": {}}
    for text in readings:
        name, option = split_assignment("--reading", text)
        if name not in ledger:
            near = one_of("it has", name, ledger)
            wrong_call(f"--reading {name}: not in the ledger{near}")
        if ledger[name].belongs == "scheme":
            wrong_call(
                f"--reading {name}: of the paper's scheme, which is an option of its engine: "
                f"longball solve --engine verlet --{SCHEME_OPTIONS[name].replace('_', '-')}"
            )
        switches[ledger[name].belongs][name] = json_or_number(option)
    return switches


def in_si(option: str, text: str, si: str, usual: str = "") -> float:
    """Return a number of an option, with or without a unit, in an SI unit."""
    with refusing(f"{option} {text}: "):
        number = read_in_si(text, si, usual)
    if number is None:
        units = ", ".join(UNITS[si])
        wrong_call(f"{option} {text}: a number is needed, alone or with a unit: {units}")
    return number


def fence_block(text: str) -> Any:
    """Return the fence that an option names: a radius, or a file that holds the block."""
    # A file may be called 120, and is meant then.
    if not Path(text).is_file():
        try:
            radius = value_of("fence.radius", text)
        except ValueError as error:
            wrong_call(f"--fence {text}: {str(error).removeprefix(f'fence.radius={text}: ')}")
        if not isinstance(radius, str):
            return {"radius": radius}
    # The scene's own check says what is wrong with the block; here it must be JSON alone.
    try:
        return json.loads(Path(text).read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        wrong_call(
            f"--fence {text}: neither a radius in m nor a file with the block of a fence in JSON, "
            'such as {"radius": 120}; longball flight --park knows parks by name'
        )
