"""The verdict for a CI system: JUnit's XML, a test case for each scene."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree

from longball.judge.answers import printable
from longball.judge.evaluation import Evaluation
from longball.judge.text import describe
from longball.judge.verdict import Comparison


def junit(evaluation: Evaluation) -> str:
    """Return an evaluation as XML: a suite for each family, and one for the candidate's conduct."""
    verdict = evaluation.verdict
    families: dict[str, list[Comparison]] = {}
    for comparison in evaluation.comparisons:
        families.setdefault(comparison.case.family, []).append(comparison)
    root = ElementTree.Element("testsuites", name=f"longball judge: {printable(verdict.candidate)}")
    for family, comparisons in families.items():
        _suite(root, family, [*map(_case, comparisons)])
    conduct = ElementTree.Element("testcase", classname="conduct", name="verdict")
    if verdict.reasons:
        reasons = printable("; ".join(verdict.reasons))
        told = printable("\n".join(c.sentence for c in verdict.complaints))
        ElementTree.SubElement(conduct, "failure", message=reasons).text = told
    _suite(root, "conduct", [conduct])
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _suite(root: ElementTree.Element, name: str, cases: Sequence[ElementTree.Element]) -> None:
    failed, skipped = (sum(case.find(kind) is not None for case in cases)
                       for kind in ("failure", "skipped"))  # fmt: skip
    counts = {"tests": len(cases), "failures": failed, "errors": 0, "skipped": skipped}
    said = {kind: str(count) for kind, count in counts.items()}
    suite = ElementTree.SubElement(root, "testsuite", {"name": name} | said)
    suite.extend(cases)


def _case(comparison: Comparison) -> ElementTree.Element:
    case = comparison.case
    element = ElementTree.Element("testcase", classname=case.family, name=printable(case.id))
    if comparison.faults:
        sentences = [describe(fault) for fault in comparison.faults]
        child = ElementTree.SubElement(element, "failure", message=printable(sentences[0]))
        child.text = printable("\n".join([*sentences, f"scene: {case.scene.as_written()}"]))
    elif not comparison.judged:
        ElementTree.SubElement(element, "skipped", message="double precision cannot decide")
    elif comparison.answer is None or comparison.empty:
        ElementTree.SubElement(element, "skipped", message="no answer")
    elif comparison.answer.error is not None:
        reason = f"refused: {comparison.answer.error}"
        ElementTree.SubElement(element, "skipped", message=printable(reason))
    return element
