"""The dicts that type checkers know are those of the models."""

from __future__ import annotations

from typing import get_args

import pytest

from longball.model import dicts, schema
from longball.model.scene import KINDS, Scene


def test_the_file_is_what_the_models_say():
    assert schema.DICTS.read_text(encoding="utf-8") == schema.dicts()


@pytest.mark.parametrize("kind", get_args(Scene))
def test_a_dict_of_a_kind_has_its_keys(kind: type[Scene]):
    known = getattr(dicts, f"{kind.__name__}Dict")
    assert known.__annotations__.keys() == kind.model_fields.keys()
    required = {name for name, field in kind.model_fields.items() if field.is_required()}
    assert known.__required_keys__ == required | {"kind"}
    assert KINDS[get_args(get_args(known.__annotations__["kind"])[0])[0]] is kind
