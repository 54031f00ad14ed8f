"""``longball converge``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from longball.cli.common import (
    AsCsv,
    Expected,
    Json,
    Knob,
    Quiet,
    Steps,
    Timeout,
    failing_unless,
    progress_bar,
    refusing,
    tell,
    to_file,
    to_picture,
    wrong_call,
)
from longball.cli.scenes import read_scenes
from longball.model.scene import Scene


def converge(
    command: Annotated[
        list[str],
        typer.Argument(metavar="-- COMMAND …{dt}…", help="{dt} stands for the time step, s."),
    ],
    scenes: Annotated[
        str | None,
        typer.Option(
            help="Lines of JSON, .csv or .parquet; by default golden flights and at-bats."
        ),
    ] = None,
    golden: Annotated[
        str | None,
        typer.Option(
            metavar="SET", help="Cases of one golden family instead; see longball golden list."
        ),
    ] = None,
    steps: Steps = None,
    knob: Knob = None,
    expected: Expected = None,
    truth: Annotated[
        bool, typer.Option(help="Errors against proven values, or among the steps themselves.")
    ] = True,
    table: AsCsv = False,
    timeout: Timeout = 60.0,
    as_json: Json = False,
    csv: Annotated[Path | None, to_file("Write the error at every step here.")] = None,
    figure: Annotated[Path | None, to_picture("Draw error against step here.")] = None,
    quiet: Quiet = False,
) -> None:
    """Measure the order of convergence of a simulator."""
    # The judge brings compiled code with it, and --help does not need it.
    from longball.convergence.figure import save_convergence
    from longball.judge.candidate import Limits
    from longball.judge.fresh import proven
    from longball.judge.step_sweep import sweep_of, takes

    if not (knob or takes(command, "dt")):
        wrong_call("the COMMAND must contain {dt}, where its time step goes")
    if scenes and golden:
        wrong_call("either --scenes or --golden, not both")
    asked = read_scenes(scenes) if scenes else golden_scenes(golden)
    proofs = [case.expected for case in proven(asked)] if truth else None
    with progress_bar("runs", 1) as advance, refusing():
        sweep = sweep_of(command, steps, knob, expected, progress=advance)
        assert sweep
        report, issues = sweep.run(command, asked, proofs, Limits(timeout), table)
    for issue in issues[:20]:
        tell(str(issue))
    if csv:
        csv.write_text(report.csv(), encoding="utf-8")
    if figure:
        save_convergence(figure, report)
    with failing_unless(report.passed):
        print(report.model_dump_json(indent=2) if as_json else report.text().rstrip())


def golden_scenes(family: str | None) -> Sequence[Scene]:
    """Return some cases of a golden family, or of those that show most."""
    from longball.golden import load
    from longball.judge.step_sweep import FAMILIES, sample

    with refusing():
        cases = load(family)
    return [case.scene for case in sample(cases, [family] if family else FAMILIES)]
