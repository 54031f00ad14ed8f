"""Cases to judge by."""

from __future__ import annotations

import pytest

from longball.engines.ivp import Ivp
from longball.judge.cases import Known, solved
from longball.model.scene import written_out
from tests.judge.material import at_bats, flights, impacts, pitches


@pytest.fixture(scope="session")
def cases() -> list[Known]:
    """Return cases whose truth is the ivp engine's."""
    scenes = map(written_out, (*at_bats(), *flights(), *impacts(), *pitches()))
    return solved([*scenes], Ivp())
