"""``longball fit``."""

from __future__ import annotations

from typing import Any

from longball.cli.messages import parsed, refusing
from longball.cli.options import Options
from longball.cli.tables import chosen_table
from longball.model.jsonl import json_or_number
from longball.pitches import Columns, PitchTypes, TableError, as_text, fit_pitches
from longball.pitches.table import NoSuchColumn


def fit(o: Options) -> None:
    """Fit the paper's distributions of speeds and locations to a table of pitches."""
    table = chosen_table(o)
    values = {name: json_or_number(value) for name, value in o.column.items()}
    columns = parsed(Columns, values, "--column ")
    # With --straight alone, all other types count as breaking: the default list has Statcast's
    # names.
    classes: dict[str, Any] = {}
    if o.straight is not None:
        classes = {"straight": tuple(o.straight.split(",")), "breaking": None}
    if o.breaking is not None:
        classes["breaking"] = tuple(o.breaking.split(","))
    types = parsed(PitchTypes, classes)
    with refusing():
        try:
            fitted = fit_pitches(table, columns, types, seed=o.seed)
        except NoSuchColumn as error:
            # Heights are optional: suggest to omit them if only their columns are missing.
            of_height = {columns.height, columns.top, columns.bottom} & {*error.missing}
            without = ", or --column height=null omits heights" if of_height else ""
            raise TableError(
                f"{error}; --column NAME=VALUE names others, see --help{without}"
            ) from None
    print(fitted.model_dump_json(indent=2) if o.json else as_text(fitted).rstrip())
