"""``longball solve``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from longball import engines
from longball.cli.cluster import Scheduler, on_cluster
from longball.cli.common import Workers, reading_from, refusing, tell, writing_to
from longball.engines.engine import Engine, ManyAtOnce
from longball.engines.lines import solve_lines


def solve(
    source: Annotated[
        str,
        typer.Argument(metavar="[SCENES|-]", help="JSON Lines, one scene per line; - reads stdin."),
    ] = "-",
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Where results go; by default stdout.")
    ] = None,
    engine: Annotated[str, typer.Option(help="One of " + ", ".join(engines.ENGINES))] = "ivp",
    method: Annotated[
        str | None,
        typer.Option(help="ivp: Taylor (default), or a method of solve_ivp: DOP853, Radau, ..."),
    ] = None,
    rtol: Annotated[
        float | None, typer.Option(help="ivp: relative tolerance of solve_ivp's methods; 5e-14.")
    ] = None,
    atol: Annotated[
        float | None, typer.Option(help="ivp: absolute tolerance of them, m and m/s; 5e-14.")
    ] = None,
    tolerance: Annotated[
        float | None, typer.Option(help="batch: error asked for at landing, m; 1e-13.")
    ] = None,
    digits: Annotated[
        int | None, typer.Option(help="enclosure, multiprecision: of each number; 30.")
    ] = None,
    dt: Annotated[float | None, typer.Option(help="verlet: the step, s; 0.05.")] = None,
    forces: Annotated[
        str | None, typer.Option(help="verlet: how drag and lift are had; old_carried.")
    ] = None,
    landing: Annotated[
        str | None, typer.Option(help="verlet: interpolated (default) or first_below.")
    ] = None,
    root: Annotated[
        str | None, typer.Option(help="verlet: Appendix B's root, first (default) or larger.")
    ] = None,
    certify: Annotated[
        bool, typer.Option("--certify", help="Give every number with a proven error.")
    ] = False,
    workers: Workers = 1,
    scheduler: Scheduler = None,
) -> None:
    """Solve scenes: one result in JSON for each line of input."""
    # fmt: off
    options = {
        "method": method, "rtol": rtol, "atol": atol, "tolerance": tolerance, "digits": digits,
        "dt": dt, "forces": forces, "landing": landing, "root": root,
    }
    # fmt: on
    with refusing():
        solver: Engine[Any] | ManyAtOnce = engines.create(
            engine, **{k: v for k, v in options.items() if v is not None}
        )
    if certify:
        from longball.engines.certify import Certifying  # brings ball arithmetic

        solver = Certifying(solver)
    solved = failed = 0
    scenes, results = reading_from(source), writing_to(output, source)
    with on_cluster(scheduler), scenes as lines, results as file:
        for result in solve_lines(lines, solver, -1 if scheduler else workers):
            file.write(result.line().encode() + b"\n")
            file.flush()
            solved += 1
            failed += (result.error or result.certificate) is not None
    if solved == 0:
        tell(f"no scenes in {source}")
    elif failed:
        tell(f"{failed} of {solved} lines could not be solved{' and certified' * certify}")
    if failed or not solved:
        raise typer.Exit(1)
