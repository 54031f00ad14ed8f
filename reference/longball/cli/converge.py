"""``longball converge``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from longball import engines
from longball.cli.common import progress_bar, reading_from, say, wrong_call
from longball.engines.at_bat import solve
from longball.model.result import Result
from longball.model.scene import Scene, SceneError, parse_scene

SAMPLE = 12  # cases of each family below: enough for a typical error
FAMILIES = ("flight-both", "at-bat")  # of the golden data, solved if no scenes are given
DIGITS = 20  # of the truth: more than any double shows


def converge(
    command: Annotated[
        list[str],
        typer.Argument(metavar="-- COMMAND …{dt}…", help="{dt} stands for the time step, s."),
    ],
    scenes: Annotated[
        str | None, typer.Option(help="JSON Lines; golden flights and at-bats if not given.")
    ] = None,
    golden: Annotated[
        str | None, typer.Option(metavar="SET", help="Cases of one golden family instead.")
    ] = None,
    steps: Annotated[
        str, typer.Option(metavar="FROM:TO:COUNT", help="s; a geometric ladder.")
    ] = "0.01:0.0001:9",
    expected: Annotated[float | None, typer.Option(help="The order in theory.")] = None,
    truth: Annotated[
        bool, typer.Option(help="Errors against proven values, or among the steps themselves.")
    ] = True,
    phases: Annotated[
        int, typer.Option(min=2, help="Of the step, averaged where an error jumps with it.")
    ] = 8,
    timeout: Annotated[float, typer.Option(min=0.001, help="s without an answer.")] = 60.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, not a text.")] = False,
    csv: Annotated[Path | None, typer.Option(help="Write every rung here.")] = None,
    figure: Annotated[Path | None, typer.Option(help="Draw errors over steps here.")] = None,
) -> None:
    """Run a family of time steps, and report observed orders against theory."""
    # The judge brings compiled code with it, and --help does not need it.
    from longball.judge.answers import as_result
    from longball.judge.candidate import Limits, run
    from longball.judge.convergence import converge as study
    from longball.judge.convergence import save_convergence

    if not any("{dt}" in word for word in command):
        wrong_call("the COMMAND must contain {dt}, where its time step goes")
    asked = read_scenes(scenes) if scenes else golden_scenes([golden] if golden else FAMILIES)
    complaints: list[str] = []

    def answers(step: float) -> Sequence[Result]:
        words = [word.replace("{dt}", repr(step)) for word in command]
        collected = run(words, asked, Limits(timeout)).collected
        complaints.extend(f"dt = {step:g}: {complaint}" for complaint in collected.complaints)
        return [as_result(answer) for answer in collected.answers.values()]

    proven = [solve(scene, engines.create("enclosure", digits=DIGITS)) for scene in asked]
    with progress_bar("runs", 1) as advance:
        try:
            report = study(
                answers,
                asked,
                ladder(steps),
                proven if truth else None,
                expected,
                phases=phases,
                progress=advance,
            )
        except ValueError as error:
            wrong_call(str(error))
    for complaint in complaints[:20]:
        say.print(f"longball: {complaint}", markup=False)
    print(report.model_dump_json(indent=2) if as_json else report.text().rstrip())
    if csv:
        csv.write_text(report.csv(), encoding="utf-8")
    if figure:
        try:
            save_convergence(figure, report)
        except ValueError as error:  # an ending that matplotlib does not know
            wrong_call(f"--figure {figure}: {error}")
    if not report.passed:
        raise typer.Exit(1)


def ladder(text: str) -> list[float]:
    """Return the steps of FROM:TO:COUNT, evenly spaced in their logarithm."""
    try:
        first, last, count = text.split(":")
        coarse, fine, rungs = float(first), float(last), int(count)
        if not (0 < fine < coarse < math.inf and 2 <= rungs <= 1000):
            raise ValueError
    except ValueError:
        wrong_call(f"--steps {text}: FROM:TO:COUNT, in s and from coarse to fine")
    return [coarse * (fine / coarse) ** (rung / (rungs - 1)) for rung in range(rungs)]


def read_scenes(source: str) -> list[Scene]:
    """Return the scenes of a file of lines; a line that is none is a wrong call."""
    with reading_from(source) as lines:
        try:
            found = [parse_scene(line) for line in lines if line.strip()]
        except SceneError as error:
            wrong_call(f"{source}: {error}")
    if not found:
        wrong_call(f"{source}: no scenes in it")
    return found


def golden_scenes(families: Sequence[str]) -> list[Scene]:
    """Return some cases of golden families, under the default reading."""
    from longball.golden import load

    try:
        found = [load(family) for family in families]
    except ValueError as error:
        wrong_call(str(error))
    plain = ([c.scene for c in cases if not c.scene.reading.model_dump()] for cases in found)
    return [scene for scenes in plain for scene in scenes[:SAMPLE]]
