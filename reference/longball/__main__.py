"""The command line as a process: signals, standard streams, and no traceback.

`longball.cli` is imported when those are in order: it takes some tenths of a second.
"""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
from types import FrameType
from typing import NoReturn

STOPPED = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


class _Closed(io.RawIOBase):
    """A standard stream that is closed: whoever needs it hears of it, and nobody else."""

    def __init__(self, name: str) -> None:
        self.stream = name

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def readinto(self, buffer: object) -> NoReturn:
        raise OSError(errno.EBADF, "is closed", self.stream)

    def write(self, data: object) -> NoReturn:
        raise OSError(errno.EBADF, "is closed", self.stream)


def _prepare_streams() -> None:
    """Make the standard streams UTF-8, whatever the locale; there are none that are not there."""
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        if stream is None:
            os.open(os.devnull, os.O_RDWR)  # no other file gets its number
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding="utf-8")
    if sys.stdin is None:
        sys.stdin = io.TextIOWrapper(io.BufferedReader(_Closed("standard input")))
    if sys.stdout is None:
        sys.stdout = io.TextIOWrapper(_Closed("standard output"), write_through=True)


def _stop(number: int, frame: FrameType | None) -> NoReturn:
    """End by an exception, so that worker processes end, too; a second signal ends at once."""
    signal.signal(number, signal.SIG_DFL)
    raise SystemExit(128 + number)


def main() -> None:
    """Run the command line."""
    heard = [number for number in STOPPED if signal.getsignal(number) is not signal.SIG_IGN]
    for number in heard:
        signal.signal(number, signal.SIG_DFL)  # an import that is interrupted has nothing to say
    _prepare_streams()

    from longball.cli import app
    from longball.cli.common import tell
    from longball.extras import MissingExtra, naming_extras

    for number in heard:
        signal.signal(number, _stop)
    try:
        with naming_extras():
            app()
    except MissingExtra as error:
        tell(str(error))
        sys.exit(2)
    except BrokenPipeError:
        # The reader of our output has left. Python would raise again when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except OSError as error:
        tell(f"{error.filename or 'output'}: {error.strerror}")
        sys.exit(2)
    except SystemExit as end:
        for number in heard:
            if end.code == 128 + number:
                tell(STOPPED[number])
        raise
    except Exception as error:
        # A bug of longball. For its traceback call `longball.cli.app` from Python.
        tell(f"unexpected {type(error).__name__}: {error}")
        sys.exit(1)


if __name__ == "__main__":
    main()
