"""The name that was meant."""

import pytest

from longball.model.names import one_of

KINDS = ["flight", "pitch", "impact", "at-bat"]


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("fligth", "flight"),
        ("PITCH", "pitch"),
        ("at_bat", "at-bat"),
        ("AtBat", "at-bat"),
        ("bat", "at-bat"),
    ],
)
def test_a_name_that_is_near_is_asked_for(given: str, meant: str):
    said = f", did you mean {meant}? The kinds are flight, pitch, impact, at-bat"
    assert one_of("the kinds are", given, KINDS) == said


@pytest.mark.parametrize("given", ["throw", "", None, 7, ["pitch"], {"pitch": 1}])
def test_what_is_near_to_none_is_not(given: object):
    said = "; the kinds are flight, pitch, impact, at-bat"
    assert one_of("the kinds are", given, KINDS) == said
