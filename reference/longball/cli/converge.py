"""``longball converge``."""

from __future__ import annotations

from pathlib import Path

from longball.cli.messages import (
    failing_unless,
    progress_bar,
    refuse_if,
    refusing,
    tell,
    wrong_call,
)
from longball.cli.scenes import chosen_kinds, read_scenes


def converge(
    command: list[str],
    scenes: str | None = None,
    golden: str | None = None,
    kind: list[str] | None = None,
    steps: str | None = None,
    knob: str | None = None,
    expected: float | None = None,
    truth: bool = True,
    as_csv: bool = False,
    timeout: float = 60.0,
    json_: bool = False,
    csv_: Path | None = None,
    figure: Path | None = None,
    quiet: bool = False,
) -> None:
    """Measure the order of convergence of a simulator."""
    # Imported here because --help must not load the engines.
    from longball.convergence.figure import save_convergence
    from longball.golden import load
    from longball.judge.candidate import Limits
    from longball.judge.fresh import proven
    from longball.judge.step_sweep import FAMILIES, sample, sweep_of, takes

    refuse_if(
        (
            not (knob or takes(command, "dt")),
            "the COMMAND must contain {dt}, where its time step goes",
        ),
        (scenes and golden, "either --scenes or --golden, not both"),
    )
    kinds = chosen_kinds(kind)
    if scenes:
        given = read_scenes(scenes)
    else:  # a sample of the family, or of those families with the clearest orders
        with refusing():
            cases = load(golden)
        given = [case.scene for case in sample(cases, [golden] if golden else FAMILIES)]
    asked = [scene for scene in given if not kinds or scene.kind in kinds]
    # A file may contain several kinds, and a simulator may support one of them.
    if not asked:
        wrong_call(f"--kind {', '.join(kinds)}: none of the scenes is of this kind")
    # Without the truth, steps are compared with each other, which hides their common errors.
    proofs = [case.expected for case in proven(asked)] if truth else None
    with progress_bar("runs", 1) as advance, refusing():
        sweep = sweep_of(command, steps, knob, expected, progress=advance)
        assert sweep
        report, issues = sweep.run(command, asked, proofs, Limits(timeout), as_csv)
    # A faulty program fails in every line; twenty messages are enough.
    for issue in issues[:20]:
        tell(str(issue))
    if csv_:
        csv_.write_text(report.csv(), encoding="utf-8")
    if figure:
        save_convergence(figure, report)
    with failing_unless(report.passed):
        print(report.model_dump_json(indent=2) if json_ else report.text().rstrip())
