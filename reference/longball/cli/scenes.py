"""Scenes that commands read: lines of JSON, or rows of a table."""

from __future__ import annotations

import json
import re
import shlex
from codecs import BOM_UTF8
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BufferedReader, BytesIO
from pathlib import Path
from typing import Annotated, BinaryIO

import typer

from longball.cli.common import fail, named, reading_from, refusing, wrong_call
from longball.model.changes import Changes
from longball.model.scene import InvalidScene, Scene, parse_scene

Source = Annotated[
    str,
    typer.Argument(
        metavar="[SCENES|-]",
        help="One scene per line of JSON, or per row of a .csv or .parquet; - reads stdin.",
    ),
]


TABLES = (".csv", ".parquet")
LINES = (".jsonl", ".ndjson", ".json", "")


def ending(file: str | Path) -> str:
    """Return the suffix of a file's name, which decides its format."""
    return Path(file).suffix.lower()


@contextmanager
def scenes_from(source: str) -> Iterator[BinaryIO]:
    """Open scenes as lines of JSON, whatever the file holds."""
    if ending(source) not in TABLES:
        with reading_from(source) as file:
            if isinstance(file, BufferedReader) and not file.isatty():
                _require_lines(file.peek(1), source)
            yield file
        return
    with refusing(f"{source}: "):
        from longball.table_files import scene_lines

        lines = scene_lines(Path(source))
    yield BytesIO(lines)


def _require_lines(beginning: bytes, source: str) -> None:
    """Refuse JSON that stands in several lines, or in one array, before each line is an error."""
    text = beginning.removeprefix(BOM_UTF8).lstrip().decode("utf-8", "replace")
    first, _, more = text.partition("\n")
    is_array = re.match(r"\[\s*(\{|$)", first.strip())
    end = 0
    if text.startswith("{"):
        with suppress(ValueError, RecursionError):
            _, end = json.JSONDecoder().raw_decode(text)
    if is_array or (first.strip() == "{" and more) or "\n" in text[:end]:
        what = "an array" if is_array else "one object over several lines"
        each = "-c '.[]'" if is_array else "-c ."
        file = "" if source == "-" else f" {shlex.quote(source)}"
        wrong_call(
            f"{named(source)} is JSON, but {what}; a scene stands in one line: jq {each}{file} "
            "writes it so"
        )


def each_scene(
    source: str, change: Changes | None = None
) -> Iterator[tuple[int, Scene | InvalidScene]]:
    """Yield the number of each line that is not blank, and its scene or why it is none.

    A scene without an id bears the number of its line.
    """
    with scenes_from(source) as lines:
        for number, line in enumerate(lines, 1):
            if line.strip():
                try:
                    scene = parse_scene(line, change)
                except InvalidScene as error:
                    yield number, error
                else:
                    yield number, scene.model_copy(update={"id": scene.id or str(number)})


def read_scenes(source: str) -> list[Scene]:
    """Return the scenes of a file, as `each_scene` has them; an invalid line is a wrong call."""
    found = []
    for number, scene in each_scene(source):
        if isinstance(scene, InvalidScene):
            wrong_call(f"{named(source)}, line {number}: {scene}")
        found.append(scene)
    if not found:
        wrong_call(f"no scenes in {named(source)}")
    return found


def one_scene(source: str, change: Changes) -> Scene:
    """Return the scene of a file with one; several, or none, are a wrong call."""
    with scenes_from(source) as lines:
        written = [line for line in lines if line.strip()]
    if len(written) != 1:
        wrong_call(f"{named(source)} has {len(written)} scenes, and one is needed")
    try:
        return parse_scene(written[0], change)
    except InvalidScene as error:
        fail(str(error))
