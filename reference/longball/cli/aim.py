"""``longball aim``."""

from __future__ import annotations

from longball.cli.changes import chosen_changes, in_si
from longball.cli.infer import answering
from longball.cli.messages import wrong_call
from longball.cli.scenes import one_scene


def aim(
    source: str = "-",
    target: str = "",
    unknown: list[str] | None = None,
    set_: list[str] | None = None,
    reading: list[str] | None = None,
) -> None:
    """Find the launches that land at a target or pass through it.

    The scene is a flight. By default its speed is fixed, and angle and direction are found.
    """
    from longball.questions.aiming import aim as aimed

    if not target:
        wrong_call("--target is missing: give a distance or a position, such as --target 110")
    # One number is a distance, two are a point on the ground, three a point of the path.
    numbers = [in_si("--target", part, "m") for part in target.split(",")]
    scene = one_scene(source, chosen_changes(set_, None, reading))
    with answering():
        for hit in aimed(scene, numbers, unknowns=unknown):
            print(hit.line())
