"""The command line as a process: signals, standard streams, and errors without a traceback.

Commands are imported last, because that takes a few tenths of a second.
"""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
import threading
import warnings
from types import FrameType
from typing import NoReturn

from longball.extras import MissingExtra, naming_extras

STOPPED = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


class _Closed(io.RawIOBase):
    """A closed standard stream, which raises an error only if it is used."""

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


def main() -> None:
    """Run the command line."""
    heard = [number for number in STOPPED if signal.getsignal(number) is not signal.SIG_IGN]
    for number in heard:
        signal.signal(number, signal.SIG_DFL)  # during the imports: no message, no traceback
    _prepare_streams()

    from longball.cli import MODULES, app, module_of

    if sys.argv[1:] and sys.argv[1] in MODULES:
        module_of(sys.argv[1])  # only this command's module: each loads other libraries

    stopped_by: list[int] = []

    def stop(number: int, frame: FrameType | None) -> NoReturn:
        # An exception, so that worker processes end, too; a second signal ends at once.
        signal.signal(number, signal.SIG_DFL)
        warnings.simplefilter("ignore")  # such as that tasks of the workers are cancelled
        threading.excepthook = lambda failure: None  # such as of the thread that misses them
        stopped_by.append(number)
        raise SystemExit

    for number in heard:
        signal.signal(number, stop)
    try:
        try:
            with naming_extras():
                app()
        finally:
            sys.stdout.flush()
    except BaseException as error:
        # After a signal, the exception may be about workers that were stopped by it.
        if stopped_by:
            _tell(STOPPED[signal.Signals(stopped_by[0])])
            sys.exit(128 + stopped_by[0])
        if BrokenPipeError in (type(error), type(error.__context__)):
            # The reader has closed the pipe. Redirect the output, because Python would raise again
            # at its final flush. The status is that of the command, if it finished.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            sys.exit(getattr(error.__context__, "code", 0))
        if not isinstance(error, Exception):
            raise
        _tell(_sentence(error))
        sys.exit(2 if isinstance(error, OSError | MissingExtra) else 1)


def _tell(sentence: str) -> None:
    from longball.cli.messages import tell  # brings the model, which --version does without

    tell(sentence)


def _sentence(error: Exception) -> str:
    if isinstance(error, MissingExtra):
        return str(error)
    # Most names of files that are not there are slips of a letter or an ending.
    if isinstance(error, FileNotFoundError) and isinstance(error.filename, str):
        from longball.model.names import nearest_file

        # Of a COMMAND: programs are looked for in the search path, and not in the folder.
        if os.path.isfile(error.filename):
            return f"{error.filename}: no such program; ./{error.filename} runs the file"
        if "--" in sys.argv[:-1] and error.filename == sys.argv[sys.argv.index("--") + 1]:
            return f"{error.filename}: no such program, neither by its path nor in those of PATH"
        return f"{error.filename}: {error.strerror}{nearest_file(error.filename)}"
    if isinstance(error, IsADirectoryError):
        return f"{error.filename}: a file is needed, and this is a folder"
    if isinstance(error, OSError):
        return f"{error.filename or 'output'}: {error.strerror}"
    # A bug of longball. For its traceback call `longball.cli.app` from Python.
    return f"unexpected {type(error).__name__}: {error}"


if __name__ == "__main__":
    main()
