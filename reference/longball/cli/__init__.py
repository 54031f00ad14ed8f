"""The command line: data on standard output, messages on standard error.

Exit status: 0 success, 1 a line or a verdict failed, 2 the call itself was wrong.
"""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

from longball import __version__
from longball.cli import golden
from longball.cli.common import tell
from longball.cli.converge import converge
from longball.cli.fit import fit
from longball.cli.homerun import homerun
from longball.cli.judge import judge
from longball.cli.measured import measured
from longball.cli.readings import readings
from longball.cli.solve import solve

app = typer.Typer(
    help="The precision reference for a simulator of baseball at-bats.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command(epilog="Example: longball solve at-bats.jsonl -o results.jsonl")(solve)
app.add_typer(golden.app, name="golden")
app.command(epilog="Example: longball judge -- longball solve --engine verlet --dt 1e-3")(judge)
app.command(
    epilog="Example: longball converge --golden flight-both --expected 2 -- "
    "longball solve --engine verlet --forces implicit --dt {dt}"
)(converge)
app.command(epilog="Example: longball homerun --samples 1000 --e 0.41:0.45:0.01 --figure P.png")(
    homerun
)
app.command(epilog="Example: longball fit pitches.csv --json > fitted.json")(fit)
app.command(epilog="Example: longball measured statcast.csv --kind batted --figure errors.png")(
    measured
)
app.command(epilog="Example: longball readings --samples 1000")(readings)


@app.callback(invoke_without_command=True)
def _version(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        print(f"longball {__version__}")
        raise typer.Exit


def main() -> None:
    """Run the command line; no traceback reaches a user."""
    try:
        app()
    except KeyboardInterrupt:
        tell("interrupted")
        sys.exit(130)
    except BrokenPipeError:
        # The reader of our output has left. Python would raise again when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except OSError as error:
        tell(f"{error.filename or 'output'}: {error.strerror}")
        sys.exit(2)
    except Exception as error:
        # A bug of longball. For its traceback call `app` from Python.
        tell(f"unexpected {type(error).__name__}: {error}")
        sys.exit(1)
