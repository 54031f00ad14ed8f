"""``longball fit``."""

from __future__ import annotations

from typing import Any

from longball.cli.messages import assignments, parsed, refusing
from longball.cli.tables import chosen_table
from longball.model.jsonl import json_or_number
from longball.pitches import Columns, PitchTypes, TableError, as_text, fit_pitches
from longball.pitches.table import NoSuchColumn


def fit(
    pitches: str = "-",
    example: bool = False,
    column: list[str] | None = None,
    straight: str | None = None,
    breaking: str | None = None,
    seed: int = 0,
    json_: bool = False,
    quiet: bool = False,
) -> None:
    """Fit the paper's distributions of speeds and locations to a table of pitches."""
    table = chosen_table(pitches, example)
    pairs = assignments("--column", column)
    values = {name: json_or_number(value) for name, value in pairs.items()}
    columns = parsed(Columns, values, "--column ")
    # With --straight alone, all other types count as breaking: the default list has Statcast's
    # names.
    classes: dict[str, Any] = {}
    if straight is not None:
        classes = {"straight": tuple(straight.split(",")), "breaking": None}
    if breaking is not None:
        classes["breaking"] = tuple(breaking.split(","))
    types = parsed(PitchTypes, classes)
    with refusing():
        try:
            fitted = fit_pitches(table, columns, types, seed=seed)
        except NoSuchColumn as error:
            # Heights are optional: suggest to omit them if only their columns are missing.
            of_height = {columns.height, columns.top, columns.bottom} & {*error.missing}
            without = ", or --column height=null omits heights" if of_height else ""
            raise TableError(
                f"{error}; --column NAME=VALUE names others, see --help{without}"
            ) from None
    print(fitted.model_dump_json(indent=2) if json_ else as_text(fitted).rstrip())
