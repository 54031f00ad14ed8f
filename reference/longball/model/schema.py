"""The contract as JSON Schema, written out from the models that the code validates with.

``python -m longball.model.schema`` writes the two files that are shipped with the package.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from longball.model.result import Result
from longball.model.scene import Scene

FOLDER = Path(__file__).parent.parent / "schema"

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def schemas() -> dict[str, dict[str, Any]]:
    """Return file names and schemas of a scene and a result."""
    scene: TypeAdapter[Scene] = TypeAdapter(Annotated[Scene, Field(discriminator="kind")])
    return {
        "scene.schema.json": {"$schema": DRAFT, "title": "Scene"} | scene.json_schema(),
        "result.schema.json": {"$schema": DRAFT} | Result.model_json_schema(),
    }


def text(schema: dict[str, Any]) -> str:
    """Return a schema as its file holds it."""
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, schema in schemas().items():
        (FOLDER / name).write_text(text(schema), encoding="utf-8")
