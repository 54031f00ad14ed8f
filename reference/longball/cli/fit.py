"""``longball fit``."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from longball.cli.common import (
    Json,
    Quiet,
    Seed,
    assignments,
    chosen_table,
    parsed,
    reading_table,
)
from longball.model.jsonl import json_or_number
from longball.pitches import Columns, PitchTypes, TableError, as_text, fit_pitches
from longball.pitches.fitted import Method
from longball.pitches.fitting import BIN_WIDTH
from longball.pitches.table import NoSuchColumn


def fit(
    pitches: Annotated[
        str, typer.Argument(metavar="[PITCHES.csv|-]", help="One row per pitch; - reads stdin.")
    ] = "-",
    example: Annotated[
        bool, typer.Option("--example", help="Fit the pitches that come with longball.")
    ] = False,
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="How to read the table; repeatable. NAME is one of "
            f"{', '.join(Columns.model_fields)}. Without it, Statcast's names and units. "
            "height=null leaves heights out.",
        ),
    ] = None,
    straight: Annotated[
        str | None, typer.Option(metavar="A,B", help="Types of pitch that are straight.")
    ] = None,
    breaking: Annotated[
        str | None, typer.Option(metavar="A,B", help="Types that break; all others if not given.")
    ] = None,
    bin_width: Annotated[
        float, typer.Option(min=0.01, help="km/h, of the histogram of speeds.")
    ] = BIN_WIDTH,
    draw_from: Annotated[
        Method, typer.Option(help="The fit that homerun will draw from.")
    ] = "maximum_likelihood",
    seed: Seed = 0,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Fit the paper's distributions of speeds and places to a table of pitches."""
    table = chosen_table(pitches, example)
    pairs = assignments("--column", column)
    columns = parsed(Columns, {name: json_or_number(value) for name, value in pairs.items()})
    classes: dict[str, Any] = {}
    if straight is not None:
        classes = {"straight": tuple(straight.split(",")), "breaking": None}
    if breaking is not None:
        classes["breaking"] = tuple(breaking.split(","))
    types = parsed(PitchTypes, classes)
    with reading_table():
        try:
            fitted = fit_pitches(
                table, columns, types, bin_width=bin_width, draw_from=draw_from, seed=seed
            )
        except NoSuchColumn as error:
            # What only a height needs can be done without.
            of_height = {columns.height, columns.top, columns.bottom} & {*error.missing}
            without = ", or --column height=null leaves heights out" if of_height else ""
            raise TableError(
                f"{error}; --column NAME=VALUE names others, see --help{without}"
            ) from None
    print(fitted.model_dump_json(indent=2) if as_json else as_text(fitted).rstrip())
