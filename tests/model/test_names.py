"""The name that was meant."""

from longball.model.names import one_of

KINDS = ["flight", "pitch", "impact", "at-bat"]


NEAR = {
    "fligth": "flight",
    "PITCH": "pitch",
    "at_bat": "at-bat",
    "AtBat": "at-bat",
    "bat": "at-bat",
}


def test_a_name_that_is_near_is_asked_for():
    kinds = "flight, pitch, impact, at-bat"
    for given, meant in NEAR.items():
        said = one_of("the kinds are", given, KINDS)
        assert said == f", did you mean {meant}? The kinds are {kinds}"
    for given in ("throw", "", None, 7, ["pitch"], {"pitch": 1}):
        assert one_of("the kinds are", given, KINDS) == f"; the kinds are {kinds}"
