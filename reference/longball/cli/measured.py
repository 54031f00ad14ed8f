"""``longball measured``."""

from __future__ import annotations

import json

from longball import engines
from longball.cli.changes import chosen_changes
from longball.cli.messages import exit_unless, note, tell
from longball.cli.options import Options
from longball.cli.tables import in_parts, read_rows
from longball.model.csv_files import write_frame
from longball.model.scene import InvalidScene
from longball.pitches.models import model_of
from longball.pitches.prediction import as_data, as_frame, as_text, joined, predict, questions
from longball.pitches.prediction import scenes as scenes_of


def measured(o: Options) -> None:
    """Predict measured pitches or batted balls, and compare.

    Each row becomes a scene, in the weather of its game. A pitch begins at its release with its
    measured spin, and is compared where it crosses the front of the plate. A batted ball has the
    spin from a published regression, and its distance is compared.
    """
    # Check all options before reading a table of a million rows.
    law = model_of(o.model)
    change = chosen_changes(o)
    solver = engines.create(o.engine)
    rows = read_rows(o, o.kind, spin=law.spin)
    prediction = joined(rows, in_parts(o, predict, rows, law, None, solver, change))
    if o.scenes:
        asked = scenes_of(rows, law, change=change)
        lines = [one.line() + "\n" for one in asked if not isinstance(one, InvalidScene)]
        # Invalid rows are counted below, with their reasons.
        o.scenes.write_text("".join(lines), encoding="utf-8")
    if o.csv:
        write_frame(as_frame(prediction), o.csv)
    if o.figure and prediction.compared.any():
        from longball.pictures import draw_errors, saved

        with saved(o.figure, (5.6, 4.2)) as (_, axes):
            draw_errors(axes, prediction)
    if o.json:
        print(json.dumps({"model": o.model} | as_data(prediction), ensure_ascii=False))
    else:
        print(as_text(prediction, o.model, law).rstrip())
    for question in questions(prediction):
        note(question)
    if prediction.failed:
        tell(f"{prediction.failed} of {len(rows)} scenes could not be solved")
    # Without a single prediction, the table is probably in other units: a failure.
    if nothing := not prediction.solved.any():
        tell("no ball could be predicted: are all columns in Statcast's units, ft, mph and rpm?")
    elif o.figure and not prediction.compared.any():
        tell("--figure: there is no error to draw, as no distance was measured")
    exit_unless(not prediction.failed and not nothing)
