"""``longball converge``."""

from __future__ import annotations

from longball.cli.messages import failing_unless, progress_bar, refusing, tell, wrong_call
from longball.cli.options import Options
from longball.cli.scenes import read_scenes


def converge(o: Options) -> None:
    """Measure the order of convergence of a simulator."""
    # Imported here because --help must not load the engines.
    from longball.convergence.figure import draw_convergence
    from longball.golden import load
    from longball.judge.candidate import Limits
    from longball.judge.fresh import proven
    from longball.judge.step_sweep import FAMILIES, sample, sweep_of, takes
    from longball.pictures import saved

    if not (o.knob or takes(o.command, "dt")):
        wrong_call("the COMMAND must contain {dt}, where its time step goes")
    if o.scenes:
        given = read_scenes(o.scenes)
    else:  # a sample of the family, or of those families with the clearest orders
        with refusing():
            cases = load(o.golden)
        given = [case.scene for case in sample(cases, [o.golden] if o.golden else FAMILIES)]
    asked = [scene for scene in given if not o.kind or scene.kind in o.kind]
    # A file may contain several kinds, and a simulator may support one of them.
    if not asked:
        wrong_call(f"--kind {', '.join(o.kind)}: none of the scenes is of this kind")
    # Without the truth, steps are compared with each other, which hides their common errors.
    proofs = [case.expected for case in proven(asked)] if o.truth else None
    with progress_bar("runs", 1) as advance, refusing():
        sweep = sweep_of(o.command, o.steps, o.knob, o.expected, progress=advance)
        assert sweep
        report, issues = sweep.run(o.command, asked, proofs, Limits(o.timeout), o.as_csv)
    # A faulty program fails in every line; twenty messages are enough.
    for issue in issues[:20]:
        tell(str(issue))
    if o.csv:
        o.csv.write_text(report.csv(), encoding="utf-8")
    if o.figure:
        with saved(o.figure, (6.4, 4.8)) as (_, axes):
            draw_convergence(axes, report)
    with failing_unless(report.passed):
        print(report.model_dump_json(indent=2) if o.json else report.text().rstrip())
