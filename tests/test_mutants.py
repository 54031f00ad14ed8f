"""The program that plants faults: what it refuses."""

import pytest

from tests import mutants

MODULE = "model/bat.py"


@pytest.mark.parametrize("lines", [{}, {"model/law.py": {"1": ["test"]}}])
def test_a_mutant_that_no_test_reaches_is_an_error(lines):
    some = list(mutants.mutants(MODULE))
    mutants.require_tests(some, mutants.Reach({"test": 0.1}, {MODULE: {"1": ["test"]}}))
    with pytest.raises(SystemExit, match=f"reaches {MODULE}"):
        mutants.require_tests(some, mutants.Reach({"test": 0.1}, lines))
