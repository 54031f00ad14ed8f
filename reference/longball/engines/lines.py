"""Scenes in, results out: one line of JSON for each, and no line without an answer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from io import BufferedIOBase
from itertools import islice
from typing import Any, NamedTuple

from longball.engines.chain import solve, solve_with_points
from longball.engines.engine import Engine, ManyAtOnce
from longball.engines.parallel import in_parallel, without_collection
from longball.model.changes import Changes
from longball.model.doubts import doubts
from longball.model.jsonl import LONGEST_LINE, json_bytes
from longball.model.result import signed
from longball.model.scene import InvalidScene, Scene, parse_scene, refused

# Lines that a worker process takes at a time: hundredths of a second, so that passing them on costs
# little, and the last worker does not run for long alone.
CHUNK, CHUNK_AT_ONCE = 32, 1024
# Read at a time at most, a free choice: hundreds of lines, and twice the buffer of a pipe.
_BYTES = 1 << 17

Line = tuple[int, bytes]


class Answer(NamedTuple):
    """The result of a line: its id, why it failed if it did, the whole as JSON, and doubts."""

    id: str | None
    failure: str | None
    text: bytes
    doubts: tuple[tuple[str, str], ...]  # keys of the scene, and questions about them


def solve_lines(
    lines: Iterable[bytes],
    engine: Engine | ManyAtOnce,
    workers: int = 1,
    points: int | None = None,
    change: Changes | None = None,
) -> Iterator[Answer]:
    """Yield the answer to each line that is not blank, in order.

    With `points` each result has that number of points of its path; `change` is applied to each
    scene first.

    With one worker no line waits for another one that is not there yet, so that two programs can
    talk through pipes: of a file or a pipe, what is there is taken at once; of anything else a line
    at a time.
    """
    at_once = isinstance(engine, ManyAtOnce) and not points
    if workers == 1:
        for chunk in _numbered(_as_they_come(lines)):
            yield from (_solve_chunk if at_once else _solve_in_turn)(chunk, engine, points, change)
        return
    # Among several workers lines are shared in chunks of the same size, however they come.
    size = CHUNK_AT_ONCE if at_once else CHUNK
    numbered = (line for chunk in _numbered(_as_they_come(lines)) for line in chunk)
    chunks = iter(lambda: list(islice(numbered, size)), [])
    tasks = ((chunk, engine, points, change) for chunk in chunks)
    for results in in_parallel(_solve_chunk, tasks, workers):
        yield from results


def _as_they_come(lines: Iterable[bytes]) -> Iterator[list[bytes]]:
    """Yield the lines that are available without waiting; wait only for the first of them."""
    if not isinstance(lines, BufferedIOBase):
        yield from ([line] for line in lines)
        return
    unfinished = b""
    while data := lines.read1(_BYTES):
        *whole, rest = (unfinished + data).split(b"\n")
        # A line that is too long is an error whatever follows: keep just enough of it to see that.
        unfinished = rest[: LONGEST_LINE + 1]
        if whole:
            yield whole
    yield [unfinished]


def _numbered(chunks: Iterable[list[bytes]]) -> Iterator[list[Line]]:
    """Yield lines with their numbers, from 1, without blank ones."""
    number = 0
    for chunk in chunks:
        numbered = enumerate(chunk, number + 1)
        number += len(chunk)
        yield [(n, line) for n, line in numbered if line.strip()]


def _solve_chunk(
    chunk: list[Line],
    engine: Engine | ManyAtOnce,
    points: int | None,
    change: Changes | None,
) -> list[Answer]:
    with without_collection():
        return list(_solve_in_turn(chunk, engine, points, change))


def _solve_in_turn(
    chunk: list[Line],
    engine: Engine | ManyAtOnce,
    points: int | None,
    change: Changes | None,
) -> Iterator[Answer]:
    """Yield the answers to lines, each as soon as the engine has it."""
    # Lines that are no scene keep their place; the engine gets the others.
    read = [_read(line, change) for _, line in chunk]
    scenes = [scene for scene in read if not isinstance(scene, InvalidScene)]
    solved = iter(
        (solve_with_points(scene, engine, points).data() for scene in scenes)
        if points
        else engine.solve_as_data(scenes)
        if isinstance(engine, ManyAtOnce)
        else (solve(scene, engine).data() for scene in scenes)
    )
    for (number, _), scene in zip(chunk, read, strict=True):
        if isinstance(scene, InvalidScene):
            yield _answer(number, refused(scene).data(), ())
        else:
            yield _answer(number, next(solved), tuple(doubts(scene)))


def _read(line: bytes, change: Changes | None) -> Scene | InvalidScene:
    try:
        return parse_scene(line, change)
    except InvalidScene as error:
        return error


def _answer(number: int, data: dict[str, Any], asked: tuple[tuple[str, str], ...]) -> Answer:
    """Return a result as the answer to a line; without an id it gets the number of the line."""
    if data["id"] is None:
        data["id"] = str(number)
    if "engine" in data:
        data["engine"] = signed(data["engine"])
    if "error" in data:
        data["error"] = f"line {number}: {data['error']}"
    failure = data.get("error") or data.get("certificate")
    return Answer(data["id"], failure, json_bytes(data), asked)
