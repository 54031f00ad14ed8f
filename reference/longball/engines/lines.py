"""Scenes in, results out: one line of JSON for each, and no line without an answer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from io import BufferedIOBase
from itertools import islice

from longball.engines.chain import solve_each
from longball.engines.engine import Engine, ManyAtOnce
from longball.model.numbers import N
from longball.model.result import Result
from longball.model.scene import InvalidScene, Scene, parse_scene

# Lines that a worker process takes at a time: some hundredths of a second.
CHUNK, CHUNK_AT_ONCE = 32, 1024
_BYTES = 1 << 17  # read at a time at most: some hundreds of lines, and twice what a pipe holds

Line = tuple[int, bytes]


def solve_lines(
    lines: Iterable[bytes], engine: Engine[N] | ManyAtOnce, workers: int = 1
) -> Iterator[Result]:
    """Yield the result of each line that is not blank, in order.

    With one worker no line waits for another one that is not there yet, so that two programs can
    talk through pipes: of a file or a pipe, what is there is taken at once; of anything else a line
    at a time.
    """
    if workers == 1:
        for chunk in _numbered(_as_they_come(lines)):
            yield from _solve_in_turn(chunk, engine)
        return
    from joblib import Parallel, delayed  # slow to import, and not needed for one worker

    size = CHUNK_AT_ONCE if isinstance(engine, ManyAtOnce) else CHUNK
    numbered = (line for chunk in _numbered([line] for line in lines) for line in chunk)
    chunks = iter(lambda: list(islice(numbered, size)), [])
    tasks = (delayed(_solve_chunk)(chunk, engine) for chunk in chunks)
    for results in Parallel(n_jobs=workers, return_as="generator")(tasks):
        yield from results


def _as_they_come(lines: Iterable[bytes]) -> Iterator[list[bytes]]:
    """Yield the lines that can be had without waiting, but for the first of them."""
    if not isinstance(lines, BufferedIOBase):
        yield from ([line] for line in lines)
        return
    unfinished: list[bytes] = []
    while data := lines.read1(_BYTES):
        unfinished.append(data)
        if b"\n" in data:
            *whole, rest = b"".join(unfinished).split(b"\n")
            unfinished = [rest]
            yield whole
    yield [b"".join(unfinished)]


def _numbered(chunks: Iterable[list[bytes]]) -> Iterator[list[Line]]:
    """Give lines their numbers, from 1, and leave out blank ones."""
    number = 0
    for chunk in chunks:
        numbered = enumerate(chunk, number + 1)
        number += len(chunk)
        yield [(n, line) for n, line in numbered if line.strip()]


def solve_line(number: int, line: bytes, engine: Engine[N] | ManyAtOnce) -> Result:
    """Return the result of a line, which is an error that names the line if it is no scene."""
    (result,) = _solve_chunk([(number, line)], engine)
    return result


def _solve_chunk(chunk: list[Line], engine: Engine[N] | ManyAtOnce) -> list[Result]:
    return list(_solve_in_turn(chunk, engine))


def _solve_in_turn(chunk: list[Line], engine: Engine[N] | ManyAtOnce) -> Iterator[Result]:
    """Yield the results of lines, each as soon as the engine has it."""
    read = [_read(line) for _, line in chunk]
    scenes = [scene for scene in read if not isinstance(scene, InvalidScene)]
    solved = iter(solve_each(scenes, engine))
    for (number, _), scene in zip(chunk, read, strict=True):
        yield _of_line(number, scene if isinstance(scene, InvalidScene) else next(solved))


def _read(line: bytes) -> Scene | InvalidScene:
    try:
        return parse_scene(line)
    except InvalidScene as error:
        return error


def _of_line(number: int, answer: Result | InvalidScene) -> Result:
    """Return the result of a line: its error, if it has one, names the line."""
    if isinstance(answer, InvalidScene):
        return Result(id=answer.scene_id, error=f"line {number}: {answer}", code=answer.code)
    error = answer.error and f"line {number}: {answer.error}"
    return answer.model_copy(update={"id": answer.id or str(number), "error": error})
