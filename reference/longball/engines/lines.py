"""Scenes in, results out: one line of JSON for each, and no line without an answer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice

from longball.engines.at_bat import solve
from longball.engines.engine import Engine
from longball.model.numbers import N
from longball.model.result import Result
from longball.model.scene import SceneError, parse_scene

CHUNK = 32  # lines that a worker process takes at a time


def solve_lines(lines: Iterable[bytes], engine: Engine[N], workers: int = 1) -> Iterator[Result]:
    """Yield the result of each line that is not blank, in order.

    With one worker each result is there before the next line is asked for, so that two programs
    can talk through pipes.
    """
    numbered = ((number, line) for number, line in enumerate(lines, 1) if line.strip())
    if workers == 1:
        for number, line in numbered:
            yield solve_line(number, line, engine)
        return
    from joblib import Parallel, delayed  # slow to import, and not needed for one worker

    chunks = iter(lambda: list(islice(numbered, CHUNK)), [])
    tasks = (delayed(_solve_chunk)(chunk, engine) for chunk in chunks)
    for results in Parallel(n_jobs=workers, return_as="generator")(tasks):
        yield from results


def solve_line(number: int, line: bytes, engine: Engine[N]) -> Result:
    """Return the result of a line, which is an error that names the line if it is no scene."""
    try:
        scene = parse_scene(line)
    except SceneError as error:
        return Result(id=error.scene_id, error=f"line {number}: {error}")
    result = solve(scene, engine)
    if result.error is None:
        return result
    return result.model_copy(update={"error": f"line {number}: {result.error}"})


def _solve_chunk(chunk: list[tuple[int, bytes]], engine: Engine[N]) -> list[Result]:
    return [solve_line(number, line, engine) for number, line in chunk]
