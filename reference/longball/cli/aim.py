"""``longball aim``."""

from __future__ import annotations

from typing import Annotated

import typer

from longball.cli.changes import ReadingOption, SetOption, chosen_changes
from longball.cli.common import wrong_call
from longball.cli.infer import Unknowns, answering
from longball.cli.scenes import Source, one_scene
from longball.model.jsonl import json_or_number


def aim(
    source: Source = "-",
    target: Annotated[
        str,
        typer.Option(
            metavar="D|X,Y|X,Y,Z",
            help="What to hit, m: a distance of the landing, its place, or a point on the way.",
        ),
    ] = "",
    unknown: Unknowns = None,
    set_: SetOption = None,
    reading: ReadingOption = None,
) -> None:
    """Find the launches that land at a target or pass through it: the scenes that hit it.

    The scene is a flight; its speed is kept, and angle and direction are found, by default.
    """
    from longball.questions.aiming import aim as aimed

    if not target:
        wrong_call("--target: what is to be hit is needed, such as --target 110")
    numbers = [json_or_number(part) for part in target.split(",")]
    scene = one_scene(source, chosen_changes(set_, None, reading))
    with answering():
        for hit in aimed(scene, numbers, unknowns=unknown):
            print(hit.line())
