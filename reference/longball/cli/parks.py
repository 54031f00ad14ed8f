"""``longball parks``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from longball import engines
from longball.cli.changes import chosen_changes
from longball.cli.cluster import on_cluster
from longball.cli.messages import exit_unless, note, refusing, show, tell, wrong_call
from longball.cli.options import Options
from longball.cli.scenes import each_scene, named
from longball.engines.parallel import in_parallel
from longball.model.jsonl import json_line
from longball.model.scene import InvalidScene
from longball.pitches.statcast import FOOT
from longball.questions.parks import InPark, Park, ignores_elevation, in_parks
from longball.questions.parks import park as park_of
from longball.questions.parks import parks as every_park


def parks(o: Options) -> None:
    """List the parks in which batted balls are home runs, and by how much.

    Each scene gets the fence of each park in turn, and the park's elevation if the scene gives a
    weather in place of a density. Without scenes, the command lists the parks and their sources.

    They are the 30 parks of 2024, with the Oakland Coliseum: no source gives the heights of the
    wall of Sutter Health Park, where the Athletics play from 2025 to 2027.
    """
    with refusing("--"):
        where = [park_of(name) for name in o.park] if o.park else [*every_park()]
    if o.source is None:
        _list(where)
        return
    change = chosen_changes(o)
    solver = engines.create(o.engine)
    failed = solved = 0
    fixed: list[int] = []

    def tasks() -> Iterator[tuple[int, Any, Sequence[Park], Any]]:
        for number, scene in each_scene(o.source, change):
            # Invalid scenes pass through as texts, so that answers keep the order of the lines.
            if isinstance(scene, InvalidScene):
                yield number, str(scene), where, solver
                continue
            if scene.kind != "pitch" and ignores_elevation(scene):
                fixed.append(number)
            yield number, scene, where, solver

    with on_cluster(o) as workers:
        for name, outcomes in in_parallel(_answer, tasks(), workers):
            solved += 1
            if isinstance(outcomes, str):
                failed += 1
                tell(f"{name}: {outcomes}")
                continue
            _show(name, outcomes, o.json)
            # A launch may be outside the fence of one park; the others still have an answer.
            failed += all(each.result.error for each in outcomes)
    if not solved:
        wrong_call(f"no scenes in {named(o.source)}")
    if fixed:
        note(
            f"air.density is a number in {len(fixed)} of {solved} scenes, the same at every park's "
            "elevation; --set 'air.density={\"temperature\": 293}' gives each park its own"
        )
    exit_unless(not failed)


def _answer(
    number: int, scene: Any, where: Sequence[Park], engine: Any
) -> tuple[str, list[InPark] | str]:
    """Return a scene's id and its outcome in each park, or its line and the fault."""
    if isinstance(scene, str):
        return f"line {number}", scene
    try:
        return str(scene.id), in_parks(scene, where, engine)
    except InvalidScene as error:
        return f"line {number}", str(error)


def _list(where: Sequence[Park]) -> None:
    rows = []
    for one in where:
        left, *_, right = one.distances
        far = f"{left / FOOT:.0f}/{max(one.distances) / FOOT:.0f}/{right / FOOT:.0f}"
        walls = " to ".join(f"{top / FOOT:g}" for top in sorted({min(one.walls), max(one.walls)}))
        vertices = str(len(one.walls))
        rows.append([one.name, one.city, one.seasons, far, walls, vertices, one.source])
    show(
        ["park", "city", "seasons", "left/farthest/right, ft", "walls, ft", "vertices", "source"],
        rows,
    )


def _show(name: str, outcomes: list[InPark], as_json: bool) -> None:
    if as_json:
        for each in outcomes:
            known = {"id": name, "park": each.park.name, "outcome": each.result.outcome}
            more = {"clearance": each.clearance, "error": each.result.error}
            print(json_line(known | {key: x for key, x in more.items() if x is not None}))
        return
    out = sum(each.is_out for each in outcomes)
    print(f"{name}: a home run in {out} of {len(outcomes)} parks")
    rows = []
    # In order of the height above the fence; parks whose fence the ball does not reach are last.
    for each in sorted(outcomes, key=lambda x: math.inf if x.clearance is None else -x.clearance):
        over = "" if each.clearance is None else f"{each.clearance:+.2f}"
        rows.append([each.park.name, str(each.result.outcome or each.result.error), over])
    show(["park", "outcome", "above the fence, m"], rows)
