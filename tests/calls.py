"""Tables of wrong calls, and what is said of each."""

from typing import Any

import pytest

import longball as lb

ERRORS = (TypeError, ValueError, KeyError, AttributeError, lb.CannotSolve)


def check_wrong_calls(table: str, names: dict[str, Any]) -> None:
    """Evaluate the calls of lines ``call -> sentence``, and look for the sentences in the errors.

    A sentence is a pattern, and may stand on a line of its own, after the arrow.
    """
    for line in table.replace("\n    -> ", " -> ").strip().splitlines():
        if not line.startswith("#"):
            call, _, said = line.partition(" -> ")
            with pytest.raises(ERRORS, match=said):
                eval(call, names)
