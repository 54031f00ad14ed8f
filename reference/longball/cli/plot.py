"""``longball plot``."""

from __future__ import annotations

from longball import engines
from longball.cli.changes import chosen_changes
from longball.cli.messages import exit_unless, note, tell, wrong_call
from longball.cli.options import Options
from longball.cli.scenes import each_scene, named
from longball.engines.chain import solve_with_path
from longball.model.scene import InvalidScene


def plot(o: Options) -> None:
    """Draw the paths of a few balls, or a spray chart of many.

    Up to 12 paths are drawn to scale, from the side and from above. The spray chart of more balls
    has home plate at the bottom. Fences are grey.
    """
    from longball.pictures import FEW, drawn, save_paths, save_spray_chart

    solver = engines.create(o.engine)
    change = chosen_changes(o)
    pictured, failed = [], 0
    for number, scene in each_scene(o.source, change):
        if isinstance(scene, InvalidScene):
            tell(f"line {number}: {scene}")
            failed += 1
            continue
        result, trajectory = solve_with_path(scene, solver)
        if result.error is None and trajectory.legs:
            around = getattr(scene, "fence", None)
            label = f"{scene.id}: {result.outcome}"
            if result.landing:
                label += f", {float(result.landing.distance):.1f} m"
            pictured.append(drawn(label, trajectory, fence=around, result=result))
        else:
            tell(f"line {number}: {result.error or 'nothing flies in an impact'}")
            failed += 1
    if pictured:
        # A spray chart shows landings, which pitches do not have.
        many = len(pictured) > FEW and any(scene.end for scene in pictured)
        (save_spray_chart if many else save_paths)(o.output, pictured)
        note(f"the picture is in {o.output}")
    elif not failed:
        wrong_call(f"no scenes in {named(o.source)}")
    exit_unless(not failed)
