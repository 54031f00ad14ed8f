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


def settings_of(command: str, commands: Sequence[str]) -> tuple[str, dict[str, Any]]:
    """Return the name of the file and the settings of a command; raise a usage error if wrong."""
    for file in map(Path, FILES):
        if not file.is_file():
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
            return file.name, tables.get(command, {})
    return "", {}


def defaults_of(
    file: str, given: Mapping[str, Any], options: Mapping[str, Any], command: str
) -> dict[str, Any]:
    """Return settings by parameter name; `options` maps names of options to parameters."""
    defaults = {}
    for name, value in given.items():
        where = f"{file}: {command}.{name}"
        if name not in options:
            wrong_call(f"{where}: no such option{one_of('they are', name, options)}")
        parameter = options[name]
        # A COMMAND has several words; other lists are for repeatable options.
        many = parameter.nargs == -1 or getattr(parameter, "multiple", False)
        if isinstance(value, dict):
            wrong_call(f"{where}: must be a value, not a table")
        if name == "command" and not isinstance(value, list):
            wrong_call(f'{where}: must be a list of words, as ["python", "my_simulator.py"]')
        if isinstance(value, list) and not many:
            wrong_call(f"{where}: takes one value, not a list")
        if getattr(parameter, "is_flag", False) and not isinstance(value, bool):
            wrong_call(f"{where}: must be true or false")
        # As texts, so that typer checks them like values of the command line.
        values = value if isinstance(value, list) else [value]
        texts = [x if isinstance(x, bool) else str(x) for x in values]
        defaults[parameter.name] = texts if many else texts[0]
    return defaults
