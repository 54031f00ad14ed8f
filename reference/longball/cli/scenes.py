"""Input of commands: scenes as lines of JSON, or as rows of a table."""

from __future__ import annotations

import json
import re
import shlex
import sys
from codecs import BOM_UTF8
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from io import BufferedReader, BytesIO
from pathlib import Path
from typing import BinaryIO

from longball.cli.messages import refusing, wrong_call
from longball.cli.options import TABLES, ending
from longball.model.changes import Changes
from longball.model.csv_files import binary
from longball.model.scene import InvalidScene, Scene, parse_scene


def named(source: str) -> str:
    """Return the name of a file of lines for messages."""
    return "standard input" if source == "-" else source


@contextmanager
def scenes_from(source: str) -> Iterator[BinaryIO]:
    """Open scenes as lines of JSON, whatever the file holds."""
    if ending(source) not in TABLES:
        # Standard input stays open.
        with nullcontext(sys.stdin.buffer) if source == "-" else open(source, "rb") as file:
            # Do not wait for the first bytes of a terminal.
            if isinstance(file, BufferedReader) and not file.isatty():
                _require_lines(file.peek(1), source)
            yield file
        return
    with refusing(f"{source}: "):
        from longball.table_files import scene_lines

        lines = scene_lines(Path(source))
    yield BytesIO(lines)


def _require_lines(beginning: bytes, source: str) -> None:
    """Reject binary files, and JSON over several lines, with one message for all lines."""
    if kind := binary(beginning):
        wrong_call(f"{named(source)}: {kind}")
    text = beginning.removeprefix(BOM_UTF8).lstrip().decode("utf-8", "replace")
    # At most the first 8 KiB, enough to distinguish lines of JSON from a single JSON text.
    first, _, more = text.partition("\n")
    # An array of scenes; a line such as [1, 2] gets its own message.
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
            f"{named(source)} is JSON, but {what}; each scene must be on one line: jq {each}{file} "
            "converts it"
        )


def each_scene(
    source: str, change: Changes | None = None
) -> Iterator[tuple[int, Scene | InvalidScene]]:
    """Yield the number of each line that is not blank, and its scene or the error.

    A scene without an id gets the number of its line.
    """
    with scenes_from(source) as lines:
        for number, line in enumerate(lines, 1):
            if line.strip():
                # A faulty line must not stop the others.
                try:
                    scene = parse_scene(line, change)
                except InvalidScene as error:
                    yield number, error
                else:
                    yield number, scene.model_copy(update={"id": scene.id or str(number)})


def read_scenes(source: str) -> list[Scene]:
    """Return the scenes of a file, see `each_scene`; an invalid line is a usage error."""
    scenes = []
    for number, scene in each_scene(source):
        if isinstance(scene, InvalidScene):
            wrong_call(f"{named(source)}, line {number}: {scene}")
        scenes.append(scene)
    # An empty file is probably a mistake, and the verdict on it would be PASSED.
    if not scenes:
        wrong_call(f"no scenes in {named(source)}")
    return scenes


def one_scene(source: str, change: Changes) -> Scene:
    """Return the single scene of a file; several, or none, are a usage error."""
    with scenes_from(source) as lines:
        written = [line for line in lines if line.strip()]
    if len(written) != 1:
        wrong_call(f"{named(source)} has {len(written)} scenes; this command needs exactly one")
    try:
        return parse_scene(written[0], change)
    except InvalidScene as error:
        wrong_call(f"{named(source)}: {error}")
