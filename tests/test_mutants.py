"""Mutation testing: the faults that the program plants, and the errors that it reports."""

from textwrap import dedent

import pytest

from tests import mutants

MODULE = "model/bat.py"


def changes(source, tmp_path, monkeypatch):
    """Changes of a module, in order, each with its line without the comment."""
    (tmp_path / "module.py").write_text(dedent(source), encoding="utf-8")
    monkeypatch.setattr(mutants, "PACKAGE", tmp_path)
    return [
        (mutant.change, mutant.code.partition("  #")[0]) for mutant in mutants.mutants("module.py")
    ]


@pytest.mark.parametrize("lines", [{}, {"model/law.py": {"1": ["test"]}}])
def test_a_mutant_that_no_test_reaches_is_an_error(lines):
    some = list(mutants.mutants(MODULE))
    mutants.require_tests(some, mutants.Reach({"test": 0.1}, {MODULE: {"1": ["test"]}}))
    with pytest.raises(SystemExit, match=f"reaches {MODULE}"):
        mutants.require_tests(some, mutants.Reach({"test": 0.1}, lines))


@pytest.mark.parametrize(
    "condition", ["n > 3", "x > 0.0", "-1 > x", "len(x) > n", "x.size > n", "n > x.shape[0]",
                  "x.sum() > n", "2 * len(x) > n"]
)  # fmt: skip
def test_two_whole_numbers_may_be_equal(condition, tmp_path, monkeypatch):
    found = changes(condition, tmp_path, monkeypatch)
    assert {("Gt -> LtE", condition), ("Gt -> GtE", condition)} <= {*found}


@pytest.mark.parametrize("condition", ["x > LIMIT", "x > 1.5", "x.left > x.right", "x > 2 * limit"])
def test_two_real_numbers_are_not_equal(condition, tmp_path, monkeypatch):
    comparisons = [
        change for change, _ in changes(condition, tmp_path, monkeypatch) if "Gt" in change
    ]
    assert comparisons == ["Gt -> LtE"]


def test_free_choices(tmp_path, monkeypatch):
    source = """
        STEPS = 20  # at most; a free choice
        DIGITS = 30

        # Limits of the search: free choices.
        NEAR, FAR = 0.1, 3.0  # m
        # Of its cost.
        BITS = {
            "sign": 2.0,
            "other": -3.0,
        }

        GRAVITY = 9.8

        def fall(t):
            if t < 1e-9 * STEPS:  # a free choice
                return -5.0
            return t + BITS["sign"] * 2 + 1

        def draw(generator):  # free choices
            x = 2.0 * generator.normal()
            return x > 4 and x + x
        """
    assert changes(source, tmp_path, monkeypatch) == [
        ("30 -> 31", "DIGITS = 30"),
        ("9.8 -> 14.700000000000001", "GRAVITY = 9.8"),
        ("Lt -> GtE", "if t < 1e-9 * STEPS:"),
        ("without -", "return -5.0"),
        ("5.0 -> 7.5", "return -5.0"),
        ("Add -> Sub", 'return t + BITS["sign"] * 2 + 1'),
        ("And -> Or", "return x > 4 and x + x"),
        ("Gt -> LtE", "return x > 4 and x + x"),
        ("Gt -> GtE", "return x > 4 and x + x"),
        ("Add -> Sub", "return x > 4 and x + x"),
    ]


def test_an_index_is_no_free_choice(tmp_path, monkeypatch):
    found = changes("first = 2.0 * x[0] + x[-1]  # a free choice", tmp_path, monkeypatch)
    assert [change for change, _ in found] == ["Add -> Sub", "0 -> 1", "without -", "1 -> 2"]


def test_every_reason_belongs_to_a_mutant():
    reasons = mutants.known_reasons()
    planted = {one.key for module in {key[0] for key in reasons} for one in mutants.mutants(module)}
    assert [key for key in reasons if key not in planted] == []
