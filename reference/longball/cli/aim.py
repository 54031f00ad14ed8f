"""``longball aim``."""

from __future__ import annotations

from longball.cli.changes import chosen_changes, in_si
from longball.cli.infer import answering
from longball.cli.messages import wrong_call
from longball.cli.options import Options
from longball.cli.scenes import one_scene


def aim(o: Options) -> None:
    """Find the launches that land at a target or pass through it.

    The scene is a flight. By default its speed is fixed, and angle and direction are found.
    """
    from longball.questions.aiming import aim as aimed

    if not o.target:
        wrong_call("--target is missing: give a distance or a position, such as --target 110")
    # One number is a distance, two are a point on the ground, three a point of the path.
    numbers = [in_si("--target", part, "m") for part in o.target.split(",")]
    scene = one_scene(o.source, chosen_changes(o))
    with answering():
        for hit in aimed(scene, numbers, unknowns=o.unknown):
            print(hit.line())
