"""The golden data: list, locate, export, check or generate them."""

from __future__ import annotations

import json
from pathlib import Path

from longball.cli.messages import exit_unless, note, progress_bar, refusing, show, tell, wrong_call
from longball.cli.options import Options
from longball.golden import files, reader
from longball.model.names import one_of


def list_(o: Options) -> None:
    """List the families, which other commands take as SET, with their sizes."""
    with refusing(f"{o.folder}: "):
        top = reader.header(o.folder or reader.DATA)
    if o.json:
        print(top.model_dump_json(include={"format", "licence", "families"}))
        return
    families = (
        (name, str(x.cases), x.about.partition("\n")[0]) for name, x in top.families.items()
    )
    show(("family", "cases", "subject"), families)
    note(f"format {top.format}, {top.licence}")


def path(o: Options) -> None:
    """Print the folder of the golden data that come with longball."""
    print(reader.DATA)


def export(o: Options) -> None:
    """Write a set as one archive, the same bytes every time."""
    target = o.output or Path(f"{files.ARCHIVE}.zip")
    # A family or a folder given by mistake would become the name of the archive.
    if target.suffix.lower() != ".zip":
        wrong_call(f"{target}: the archive's name must end in .zip; --folder DIR gives the set")
    with refusing():
        count = files.export(target, o.folder or reader.DATA)
    note(f"{count} files in {target}")


def write(o: Options) -> None:
    """Solve every case with proven bounds and write the set to DIR.

    An interrupted run resumes where it stopped. The cases take about ten minutes on two cores, the
    probabilities P(e) a little longer.
    """
    from longball.golden import home_runs, writer  # they load the engines

    # Check names first: the writer works for minutes before it needs them.
    families = reader.header().families
    if unknown := set(o.family or []) - families.keys():
        name = min(unknown)
        wrong_call(f"--family {name}: there is none{one_of('the families are', name, families)}")
    if o.part != "probability":
        with progress_bar("cases", 1) as advance:
            count = writer.write(
                o.folder, only=o.family or None, workers=o.workers, progress=advance
            )
        note(f"{count} cases in {o.folder}")
    # Probabilities belong to no family.
    if o.part != "cases" and not o.family:
        with progress_bar("probabilities", 1) as advance:
            count = home_runs.write_probabilities(o.folder, workers=o.workers, progress=advance)
        note(f"{count} readings' probabilities in {o.folder}")


def coverage(o: Options) -> None:
    """Count the mistakes that your own scenes and the golden data would detect.

    A mistake is an edit of the model, such as another symbol, a flipped sign, a factor or a missing
    term. The counts include the edits that your scenes or the golden data detect.
    """
    from longball.cli.scenes import read_scenes
    from longball.judge.coverage import coverage as covered
    from longball.judge.diagnosis.findings import many
    from longball.judge.fresh import proven

    # Only proven answers detect an edit; the user's scenes have none yet.
    with refusing():
        own = proven(list(read_scenes(o.scenes)), "own")
    with progress_bar("edits", EDITS // o.every) as advance:
        detected = covered([*reader.load("all"), *own], o.every, advance)
    mine = [i for i, case in enumerate(detected.cases) if case.family == "own"]
    shown = detected.noticed[:, mine].sum(axis=1) > 0
    # Edits with few bits are the most common mistakes: list these first.
    # `bits` is the cost of an edit in the judge's search; see docs/truth.md.
    likeliest = sorted(range(len(shown)), key=detected.bits.__getitem__)
    missed = [detected.told(i) for i in likeliest if not shown[i]]
    by_stage = detected.by_stage(shown)
    if o.json:
        stages = [{"stage": name, "edits": n, "noticed": k} for name, n, k in by_stage]
        print(json.dumps({"stages": stages, "missed": missed[: o.most]}, ensure_ascii=False))
        return
    rows = [(name, f"{n:,}", f"{k:,}", f"{k / n:.0%}") for name, n, k in by_stage]
    show(("stage", "edits", "detected", ""), rows)
    if missed[: o.most]:
        print("\nmissed, with a golden case that detects it:")
    for one in missed[: o.most]:
        print(f"  {one['stage']}: {one['edit']} ({one['case']})")
    note(f"{many(len(mine), 'scene')}: {int(shown.sum()):,} of {many(len(shown), 'edit')} detected")


EDITS = 50_000  # approximate number, for the progress bar


def check(o: Options) -> None:
    """Verify a set: checksums, schema, and the results by solving again."""
    from longball.golden import checker  # it loads the engines

    target = o.folder or reader.DATA
    if not target.is_dir():
        wrong_call(f"{target}: there is no such folder")
    with progress_bar("cases", 1) as advance:
        report = checker.check(
            target,
            sample=o.sample,
            seed=o.seed,
            independent=o.independent,
            workers=o.workers,
            progress=advance,
        )
    for failure in report.failures:
        print(failure)
    if report.left_out:
        tell(report.left_out)
    if report.confirmed:
        note(report.confirmed)
    # The oracle reads the shipped set only.
    if target.resolve() == reader.DATA:
        note("python -m tests.oracle_check solves them by a program that shares no line with these")
    verdict = f"{len(report.failures)} failures" if report.failures else "nothing is wrong"
    count = f"{report.cases} cases, with those of P(e)"
    note(f"{count}; {report.solved_again} solved again: {verdict}")
    exit_unless(not report.failures)
