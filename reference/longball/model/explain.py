"""Messages for invalid data: the key's path, the fault, and the correct form.

Pydantic finds the faults; its own words name Python types, which mean nothing to users.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel, Tag, ValidationError
from pydantic.fields import FieldInfo

from longball.model.annotations import is_model, within
from longball.model.block import SMALLEST, Quantity
from longball.model.names import did_you_mean, letters, one_of
from longball.model.units import unit_of


def explain(error: ValidationError, model: type[BaseModel]) -> str:
    """Return one sentence for each fault in data that do not fit a `model`."""
    # A union reports the same fault once for each of its forms.
    sentences = (_explain_fault(dict(fault), model) for fault in error.errors())
    return "; ".join(dict.fromkeys(sentences))


def _explain_fault(fault: dict[str, Any], model: type[BaseModel]) -> str:
    location, model_asked = fault["loc"], model
    steps, block, annotation, about = _resolved(model, location)
    where = "".join(f"[{x}]" if isinstance(x, int) else f".{x}" for x in steps).removeprefix(".")
    match fault["type"]:
        case "extra_forbidden":
            key, keys = str(location[-1]), [*block.model_fields]
            # The name of a column as a key of JSON, such as "launch.velocity[0]".
            outer = re.split(r"[.\[]", key)[0]
            if outer != key and outer in keys:  # also of a table that gives the block whole
                return f"{where}: unknown key; put it inside {outer}, not beside it"
            from longball.model.inputs import TRACKED  # which knows scenes

            if where in TRACKED:
                made = f"{', '.join(keys)}; lb.launch(…) or --set {where}=… computes them"
                return f"{where}: unknown key; the keys here are {made}"
            # A key of another block, such as density outside of air,
            homes = [name for name in model.model_fields if key in keys_of(model, [name])]
            # or of a block inside this one, such as temperature, of air.density.
            path = [str(step) for step in steps[:-1]]
            inner = [k for k in keys if path and key in keys_of(model, [*path, k])]
            homes += [".".join([*path, k]) for k in inner]
            if homes and not any(letters(key) == letters(name) for name in keys):
                here = f"the keys here are {', '.join(keys)}"
                return f"{where}: unknown key; {here}; {key} is a key of {' and of '.join(homes)}"
            return f"{where}: unknown key{one_of('the keys here are', key, keys)}"
        case "missing" if isinstance(location[-1], int):
            # Pydantic reports each missing component; one sentence is enough.
            vector, count = where.rpartition("[")[0], len(fault["input"])
            form = _listed(annotation, about)
            return f"{vector}[{count}]: is missing; {vector} must be {form}"
        case "missing":
            form = _form_of(annotation, about)
            return f"{where}: is missing{form and f'; it is {form}'}"
        case "float_type" if fault["input"] is None and isinstance(location[-1], int):
            return f"{where}: is missing, or null"  # in a vector, of which other numbers are given
        case "too_long" | "too_short" as wrong:
            bound, key = ("most", "max_length") if wrong == "too_long" else ("least", "min_length")
            # Give the form, such as [x, y, z] in m, not only the length.
            limit, given = fault["ctx"][key], fault["ctx"]["actual_length"]
            form = _listed(annotation, about)
            if form != "a list":
                return f"{where}: must be {form}, and has {given} values"
            return f"{where}: takes at {bound} {limit} values, and has {given}"
        case "tuple_type" | "list_type":
            return f"{where}: must be {_listed(annotation, about)} (got {short(fault['input'])})"
        case "model_type" | "model_attributes_type":
            return f"{where}: must be {_form_of(annotation, about)} (got {short(fault['input'])})"
        case "float_type":
            tags = [str(tag) for tag in _forms(_resolved(model_asked, location[:-1])[2])]
            others = [tag.strip("<>") for tag in tags[1:]]
            unit = unit_of(about)
            form = f"a number{f' in {unit}' if unit else ''}"
            if len(others) > 1:
                form += f", or an object with a law: {', '.join(others)}"
            return f"{where}: must be {form} (got {short(fault['input'])})"
        case "string_type":
            also = " or a whole number" if where == "id" else ""
            return f"{where}: must be a text{also} (got {short(fault['input'])})"
        case "value_error":
            sentence = str(fault["ctx"]["error"])
            return f"{where}: {sentence}" if where else sentence
        case "union_tag_invalid":
            forms = re.findall(r"<(\w+)>", fault["ctx"]["expected_tags"])
            laws = [name for name in forms if name != "number"]
            given = fault["input"].get("law")
            what = "is missing" if given is None else f"{short(given)} is not a law here"
            return f"{where}.law: {what}{one_of('the laws are', given, laws)}"
        case "json_invalid":  # pydantic's parser is stricter than Python's
            return f"not JSON: {fault['ctx']['error']}"
        case "literal_error":
            words = re.findall(r"'([^']*)'", fault["ctx"]["expected"])
            sentence = f"{_in_our_words(fault['msg'])} (got {short(fault['input'])})"
            return f"{where}: {sentence}{did_you_mean(fault['input'], words)}"
        case "greater_than_equal" | "less_than_equal" as side:
            ((_, limit),) = fault["ctx"].items()
            bound = "at least" if side == "greater_than_equal" else "at most"
            sentence = f"must be {bound} {limit:g}{_UNITS.get(str(location[-1]), '')}"
            # The limit 1e-30 is a detail of the arithmetic: users understand "positive".
            if side == "greater_than_equal" and limit in (SMALLEST, 0.0):
                sentence = "must be positive" if limit else "must not be negative"
            return f"{where}: {sentence} (got {short(fault['input'])})"
    return f"{where}: {_in_our_words(fault['msg'])} (got {short(fault['input'])})"


def _listed(annotation: Any, about: str) -> str:
    """Return the form of a list, from its annotation and the unit in its description."""
    numbers = next((x for x in map(get_args, within(annotation)) if is_vector(x)), ())
    unit = unit_of(about)
    places = ", ".join("xyz"[3 - len(numbers) :])  # a place on the plate's plane is [y, z]
    return f"[{places}]{f' in {unit}' if unit else ''}" if numbers else "a list"


def _form_of(annotation: Any, about: str) -> str:
    """Return the form of a vector, or of a block by its keys; empty for other values."""
    if any(map(is_vector, map(get_args, within(annotation)))):
        return _listed(annotation, about)
    block = next(filter(is_model, within(annotation)), None)
    return f"an object with the keys {', '.join(block.model_fields)}" if block else ""


def is_vector(parts: tuple[Any, ...]) -> bool:
    """True if the parts of an annotation are those of a vector."""
    return len(parts) in (2, 3) and all(part == Quantity for part in parts)


def _in_our_words(message: str) -> str:
    """Return pydantic's message on a value in our words, as the end of a sentence."""
    message = re.sub("^(Input|String) should", "must", message)
    return message.replace("a valid integer", "a whole number").replace("a valid ", "a ")


# Hints for numbers that are probably in another unit if they exceed their limits.
_UNITS = {
    "temperature": " K; 20 °C is 293.15 K",
    "pressure": " Pa; 1013 hPa are 101300 Pa",
    "latitude": " rad; 45° is 0.7854 rad",
}


def _resolved(
    model: type[BaseModel], location: tuple[str | int, ...]
) -> tuple[list[str | int], type[BaseModel], Any, str]:
    """Return the keys of a location, its innermost block, and the type and description there.

    Pydantic inserts the tags of unions among the keys. The annotations distinguish them, so that
    keys may have any name.
    """
    # Follow the annotations along the keys of the location.
    annotation: Any = model
    steps: list[str | int] = []
    about = ""
    for step in location:
        forms = _forms(annotation)
        if step in forms:
            annotation = forms[step]
        else:
            steps.append(step)
            model = next(filter(is_model, within(annotation)), model)
            field = None if isinstance(step, int) else model.model_fields.get(step)
            if field:
                annotation, about = field.annotation, field.description or ""
    return steps, model, annotation, about


def parts_of(model: type[BaseModel], keys: Sequence[str]) -> list[FieldInfo]:
    """Return the fields at a path of keys, one for each form of the blocks on it."""
    annotations: list[Any] = [model]
    fields: list[FieldInfo] = []
    for key in keys:
        models = [x for annotation in annotations for x in filter(is_model, within(annotation))]
        fields = [each.model_fields[key] for each in models if key in each.model_fields]
        annotations = [field.annotation for field in fields]
    return fields


def keys_of(model: type[BaseModel], keys: Sequence[str]) -> list[str]:
    """Return the keys of the blocks at a path of keys."""
    annotations = [field.annotation for field in parts_of(model, keys)] if keys else [model]
    models = [x for annotation in annotations for x in filter(is_model, within(annotation))]
    return [key for each in models for key in each.model_fields]


def _forms(annotation: Any) -> dict[str | int, Any]:
    """Return the forms of a union by their tags."""
    parts = [get_args(x) for x in within(annotation) if get_origin(x) is Annotated]
    return {tag.tag: form for form, *rest in parts for tag in rest if isinstance(tag, Tag)}


def short(value: Any) -> str:
    """Return a value as text for a message, of at most 40 characters."""
    # JSON's words, null and true, not Python's.
    text = json.dumps(value) if value is None or isinstance(value, bool) else repr(value)
    return text if len(text) <= 40 else text[:37] + "..."
