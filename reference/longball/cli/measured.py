"""``longball measured``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from longball import engines
from longball.cli.changes import FenceOption, ReadingOption, SetOption, chosen_changes
from longball.cli.common import (
    AnyEngine,
    Json,
    Quiet,
    assignments,
    chosen_table,
    note,
    reading_table,
    refusing,
    tell,
    to_file,
    to_picture,
)
from longball.model.csv_files import write_frame
from longball.model.scene import InvalidScene
from longball.pitches.models import MODELS, model_of
from longball.pitches.prediction import as_data, as_frame, as_text, predict, questions, scenes
from longball.pitches.statcast import GAMES, Kind, read_measured
from longball.pitches.table import NoSuchColumn, TableError


def measured(
    table: Annotated[
        str, typer.Argument(metavar="[TABLE.csv|-]", help="In Statcast's columns; - reads stdin.")
    ] = "-",
    kind: Annotated[Kind, typer.Option(help="What of the table is predicted.")] = "pitch",
    example: Annotated[
        bool, typer.Option("--example", help="Take the day of pitches that comes with longball.")
    ] = False,
    model: Annotated[
        str, typer.Option(metavar="NAME", help=f"Of flight: {', '.join(MODELS)}.")
    ] = "nathan",
    games: Annotated[
        Path | None,
        typer.Option(
            metavar="GAMES.csv",
            help="game_pk, temperature (°F), and elevation (ft) or park of each game; by default "
            "those of the example. Other games are played at 20 °C at sea level.",
        ),
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=COLUMN",
            help="What the table calls Statcast's column NAME, as vx0=VX0; repeatable.",
        ),
    ] = None,
    set_: SetOption = None,
    fence: FenceOption = None,
    reading: ReadingOption = None,
    engine: AnyEngine = "batch",
    scenes_file: Annotated[
        Path | None, to_file("Write the scenes here.", "--scenes", metavar="FILE")
    ] = None,
    csv_file: Annotated[
        Path | None, to_file("Write each prediction here, in SI units.", "--csv", metavar="FILE")
    ] = None,
    figure: Annotated[
        Path | None, to_picture("Draw the errors here: .png, .svg, .pdf", metavar="FILE")
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Predict measured pitches or batted balls, and compare.

    Each row becomes a scene, in the weather of its game. A pitch begins at its release, with the
    spin that was measured, and is compared where it crosses the front of the plate. A batted ball
    has the spin that a published regression expects of it, and is compared in its distance.
    """
    source = chosen_table(table, example)
    with refusing("--"):
        law = model_of(model)
    names = assignments("--column", column)
    change = chosen_changes(set_, fence, reading)
    with refusing():
        solver = engines.create(engine)
    with reading_table():
        try:
            rows = read_measured(source, kind, games or GAMES, spin=law.spin, names=names)
        except NoSuchColumn as error:
            raise TableError(f"{error}{_instead(error.missing)}") from None
        if scenes_file:
            asked = (
                one for one in scenes(rows, law, change=change) if not isinstance(one, InvalidScene)
            )
            lines = [scene.line() + "\n" for scene in asked]
            scenes_file.write_text("".join(lines), encoding="utf-8")
        prediction = predict(rows, law, engine=solver, change=change)
    if csv_file:
        write_frame(as_frame(prediction), csv_file)
    if figure and prediction.compared.any():
        from longball.pictures import save_prediction

        save_prediction(figure, prediction)
    if as_json:
        print(json.dumps({"model": model} | as_data(prediction), ensure_ascii=False))
    else:
        print(as_text(prediction, model, law).rstrip())
    for question in questions(prediction):
        note(question)
    if prediction.failed:
        tell(f"{prediction.failed} of {len(rows)} scenes could not be solved")
    if nothing := not prediction.solved.any():
        tell("no ball could be predicted: are all columns in Statcast's units, ft, mph and rpm?")
    elif figure and not prediction.compared.any():
        tell("--figure: there is no error to draw, as no distance was measured")
    if prediction.failed or nothing:
        raise typer.Exit(1)


def _instead(missing: Sequence[str]) -> str:
    """Return hints for missing columns."""
    of_spin = {*missing} & {"spin_axis", "release_spin_rate"}
    said = "; --column NAME=COLUMN says what the table calls it" if {*missing} - of_spin else ""
    if of_spin:
        without = ", ".join(name for name, law in MODELS.items() if not law.spin)
        said += (
            f"; Statcast's tables have spin_axis from 2020 on, and the models {without} "
            "(--model) do without a spin"
        )
    return said
