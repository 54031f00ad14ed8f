"""Configuration files: longball.toml, or [tool.longball] of pyproject.toml.

The file is in the working directory, and has a table for each command.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from longball.cli.messages import wrong_call
from longball.model.names import one_of

# The first file with settings is used.
FILES = ("longball.toml", "pyproject.toml")

# Alternatives: an option on the command line also overrides the others of its group in the file.
INSTEAD = (("command", "results"), ("golden", "scenes", "random"), ("steps", "knob"))


def settings_of(
    command: str, commands: Sequence[str], forms: Mapping[str, Any]
) -> tuple[str, dict[str, Any]]:
    """Return the name of the file, and the values of a command's options as they would be typed.

    `forms` are those of its options, by name. Wrong settings are usage errors.
    """
    for file in map(Path, FILES):
        if command not in commands or not file.is_file():
            continue
        try:
            tables = tomllib.loads(file.read_text(encoding="utf-8"))
        except ValueError as error:  # also of text that is not UTF-8
            wrong_call(f"{file}: not TOML: {error}")
        # A pyproject.toml has tables of other tools, too.
        if file.name == "pyproject.toml":
            tables = tables.get("tool", {}).get("longball", {})
        # Check the tables of all commands, so that a misspelt name is reported early.
        for name, table in tables.items():
            if name not in commands:
                wrong_call(f"{file}: {name}: no such command{one_of('they are', name, commands)}")
            if not isinstance(table, dict):
                wrong_call(f"{file}: {name}: must be a table of options, [{name}]")
        # A pyproject.toml without a table of ours is no file of settings.
        if tables:
            known = {name.replace("_", "-"): (name, form) for name, form in forms.items()}
            given = tables.get(command, {}).items()
            return file.name, dict(_setting(f"{file}: {command}", known, *pair) for pair in given)
    return "", {}


def _setting(
    where: str, known: Mapping[str, tuple[str, Any]], key: str, value: Any
) -> tuple[str, Any]:
    """Return the option of a key, and its value as text, as texts or as a bool."""
    if key not in known:
        wrong_call(f"{where}.{key}: no such option{one_of('they are', key, known)}")
    name, form = known[key]
    # A COMMAND has several words; other lists are for repeatable options.
    many = isinstance(form, list)
    if isinstance(value, dict):
        wrong_call(f"{where}.{key}: must be a value, not a table")
    if name == "command" and not isinstance(value, list):
        wrong_call(f'{where}.{key}: must be a list of words, as ["python", "my_simulator.py"]')
    if isinstance(value, list) and not many:
        wrong_call(f"{where}.{key}: takes one value, not a list")
    if (form is bool) != isinstance(value, bool):
        wrong_call(f"{where}.{key}: must {'' if form is bool else 'not '}be true or false")
    if many:
        return name, [str(word) for word in (value if isinstance(value, list) else [value])]
    return name, value if form is bool else str(value)
