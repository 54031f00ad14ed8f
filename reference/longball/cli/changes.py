"""Options that change scenes: --set, --fence, --reading."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from longball.cli.messages import refusing, wrong_call
from longball.cli.options import Options
from longball.model.changes import Changes, changes_of, value_of
from longball.model.jsonl import json_or_number
from longball.model.names import one_of
from longball.model.readings import LEDGER, SCHEME_OPTIONS, Belongs
from longball.model.units import UNITS, read_in_si


def chosen_changes(o: Options, blocks: Mapping[str, Any] | None = None) -> Changes:
    """Return the changes of --set, --fence and --reading, of those that a command has.

    `blocks` are applied first, so that options can change them.
    """
    given = vars(o)
    # Only readings of the physics change scenes; the others are for homerun and the engine verlet.
    switches = chosen_switches(given.get("reading"))
    for belongs, named in switches.items():
        if belongs != "scene" and named:
            wrong_call(f"--reading {next(iter(named))}: it is for longball homerun, not for scenes")
    whole = {**(blocks or {})}
    whole |= {f"reading.{name}": option for name, option in switches["scene"].items()}
    return changes(given.get("set"), given.get("fence"), whole)


def changes(
    values: Mapping[str, str] | None, fence: str | None, whole: Mapping[str, Any]
) -> Changes:
    """Return changes of whole blocks, then of --fence, then of --set."""
    if fence is not None:
        whole = {**whole, "fence": fence_block(fence)}
    with refusing("--set "):
        return changes_of((values or {}).items(), whole)


def chosen_switches(readings: Mapping[str, str] | None) -> dict[Belongs, dict[str, Any]]:
    """Return the switches of --reading options, grouped by the part that they change."""
    ledger = {entry.switch: entry for entry in LEDGER if entry.is_switch}
    switches: dict[Belongs, dict[str, Any]] = {"scene": {}, "sampling": {}, "figure": {}}
    for name, option in (readings or {}).items():
        if name not in ledger:
            near = one_of("it has", name, ledger)
            wrong_call(f"--reading {name}: not in the ledger{near}")
        if ledger[name].belongs == "scheme":
            wrong_call(
                f"--reading {name}: a reading of the paper's scheme is an option of its engine: "
                f"longball solve --engine verlet --{SCHEME_OPTIONS[name].replace('_', '-')}"
            )
        switches[ledger[name].belongs][name] = json_or_number(option)
    return switches


def in_si(option: str, text: str, si: str, usual: str = "") -> float:
    """Return the value of an option in an SI unit; its text may have another unit."""
    with refusing(f"{option} {text}: "):
        number = read_in_si(text, si, usual)
    if number is None:
        units = ", ".join(UNITS[si])
        wrong_call(f"{option} {text}: must be a number, alone or with a unit: {units}")
    return number


def fence_block(text: str) -> Any:
    """Return the `fence` block of an option: a radius, or a file with the block."""
    # An existing file has priority, even if it is called 120.
    if not Path(text).is_file():
        try:
            radius = value_of("fence.radius", text)
        except ValueError as error:
            wrong_call(f"--fence {text}: {str(error).removeprefix(f'fence.radius={text}: ')}")
        if not isinstance(radius, str):
            return {"radius": radius}
    # Here the file must only be JSON; the validation of the scene checks the block.
    try:
        return json.loads(Path(text).read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        wrong_call(
            f"--fence {text}: must be a radius, such as 120 or 400ft, or a JSON file with a fence "
            'block, such as {"radius": 120}; longball flight --park takes the name of a park'
        )
