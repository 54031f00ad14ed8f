"""``longball spin``."""

from __future__ import annotations

import json

import numpy as np

from longball.api import as_scene
from longball.cli.changes import chosen_changes, in_si
from longball.cli.infer import answering
from longball.cli.messages import note, refusing, show, wrong_call
from longball.cli.options import Options
from longball.cli.tables import answers, pitches_of, show_each, show_types
from longball.model.doubts import doubts
from longball.model.jsonl import json_line
from longball.model.scene import PitchScene
from longball.pitches.models import model_of
from longball.pitches.statcast import RPM, SEA_LEVEL, USUAL_TEMPERATURE
from longball.questions.movement import PFX, Movement, clock
from longball.questions.spin import measured_spin, spin_for


def spin(o: Options) -> None:
    """Compute the spin that causes the movement of measured pitches, and its active share.

    The force perpendicular to the path gives C_L in the weather of each game, and the model's law
    of lift gives the spin. Text output has the medians of each pitch type, JSON output a line for
    each pitch, in SI units.

    With --speed, --up and --across in place of a table, it computes the spin of a single pitch with
    this movement, relative to a flight under gravity alone, at 20 °C at sea level.
    """
    law = model_of(o.model)
    if o.speed is not None:
        if o.table != "-":
            wrong_call("--speed is for a single pitch: omit the table")
        why = "it is for a table; with --speed there is none"
        o.refuse("example games column workers scheduler", why)
        thrown = {
            "speed": in_si("--speed", o.speed, "m/s"),
            "release": [in_si("--release", part, "m") for part in o.release.split(",")],
            "spin": [0.0, 0.0, 0.0],
        }
        moved = Movement(in_si("--across", o.across, "m"), in_si("--up", o.up, "m"))
        blocks = law.blocks(USUAL_TEMPERATURE, SEA_LEVEL)
        with answering():
            change = chosen_changes(o)
            pitch = as_scene(change({"kind": "pitch", "pitch": thrown} | blocks))
            for key, question in doubts(pitch):
                note(f"{key}: {question}")
            _show(spin_for(pitch, moved, PFX if o.pfx else None), o.json)
        return
    o.refuse("release up across pfx set", "it needs --speed, the speed of a single pitch")
    pitches = pitches_of(o, spin=True)
    with refusing(f"--model {o.model}: "):
        columns = answers(o, measured_spin, pitches, law)
    if o.json:
        show_each(pitches, columns)
    else:
        shown = {
            "C_D": columns["drag_coefficient"],
            "C_L": columns["lift_coefficient"],
            "across, rpm": columns["transverse"] / RPM,
            "active share": columns["active_share"],
        }
        show_types(pitches, shown)
    above, beyond = (columns["active_share"] > 1.0).sum(), np.isnan(columns["transverse"]).sum()
    # Neither is a failure: these rows have numbers, or NaN.
    if above:
        note(f"the active share of {above} pitches is above 1: they move more than their spin can")
    if beyond:
        note(f"the C_L of {beyond} pitches exceeds the limit of the law of lift: they have no spin")


def _show(pitch: PitchScene, as_json: bool) -> None:
    """Print the spin of a pitch: its size, and the direction in which it pushes the ball."""
    turning, ahead = np.array(pitch.pitch.spin), np.array(pitch.pitch.thrown)
    rate, push = float(np.linalg.norm(turning)), np.cross(turning, ahead)
    direction = clock(*push[1:].tolist())
    if as_json:
        scene = json.loads(pitch.line())
        print(json_line({"transverse": rate, "clock": direction, "scene": scene}))
        return
    rows = [["spin", f"{rate:.1f} rad/s", f"{rate / RPM:.0f} rpm"], ["direction", direction, ""]]
    show(["", "SI", "customary"], rows)
