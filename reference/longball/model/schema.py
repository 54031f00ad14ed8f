"""JSON Schemas of scenes and results, from the models that validate them.

``python -m longball.model.schema`` writes the two files of the package.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from longball.model.result import Result
from longball.model.scene import Scene

FOLDER = Path(__file__).parent.parent / "schema"

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def published(name: str, schema: dict[str, Any]) -> dict[str, Any]:
    """Return a schema for publication: with its name, and JSON Schema's keywords alone."""
    plain: dict[str, Any] = _plain(schema)
    return {"$schema": DRAFT, "$id": f"urn:longball:schema:{name}"} | plain


def _plain(schema: Any) -> Any:
    """Return a part of a schema without OpenAPI's `discriminator`."""
    # Instead, the constant that distinguishes a form is a required key.
    if isinstance(schema, list):
        return [_plain(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    plain = {key: _plain(part) for key, part in schema.items() if key != "discriminator"}
    # The models add a list of their fields to their docstrings; the schema has its own.
    if isinstance(about := plain.get("description"), str):
        plain["description"] = re.split(r"\n\n(?:Parameters|Attributes)\n", about)[0]
    properties = schema.get("properties", {})
    told_by = [key for key, part in properties.items() if "const" in part]
    if told_by:
        plain["required"] = list(dict.fromkeys([*told_by, *schema.get("required", [])]))
    return plain


def schemas() -> dict[str, dict[str, Any]]:
    """Return file names and schemas of a scene and a result."""
    scene: TypeAdapter[Scene] = TypeAdapter(Annotated[Scene, Field(discriminator="kind")])
    return {
        "scene.schema.json": published("scene", {"title": "Scene"} | scene.json_schema()),
        "result.schema.json": published("result", Result.model_json_schema()),
    }


def text(schema: dict[str, Any]) -> str:
    """Return a schema as the text of its file."""
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    for name, schema in schemas().items():
        (FOLDER / name).write_text(text(schema), encoding="utf-8")
