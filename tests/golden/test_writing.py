"""Writing and checking a small golden set."""

from __future__ import annotations

import json
import math
import shutil
from functools import cache
from pathlib import Path

import pytest

from longball.engines.enclosure import Enclosure
from longball.golden import home_runs, writer
from longball.golden.case import FOUND, Draft, Drafts
from longball.golden.checker import _apart, check
from longball.golden.condition import Sensitivity, attainable_errors, sensitivity
from longball.golden.files import CHECKSUMS, PARTIAL, write_files
from longball.golden.reader import DATA, drafts, header, load, probabilities
from longball.golden.truth import make, prove
from longball.home_run.quadrature import Nodes
from longball.model.inputs import inputs
from longball.model.quantities import numbers_of, replaced
from longball.model.result import Bounded, Result
from longball.model.scene import parse_scene

IMPACTS = [
    Draft.model_validate_json(line) for line in (DATA / "impact.jsonl").read_bytes().splitlines()
]
FEW = Drafts("Three impacts.", IMPACTS[:3])
SMALL = {"few": FEW}


# The cases of this set are few, and each test writes them anew: each is solved once.
made = cache(make)


@pytest.fixture(autouse=True, scope="module")
def each_solved_once():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(writer, "make", made)
        yield


def files(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.mark.nightly
def test_the_bytes_do_not_depend_on_the_workers(tmp_path: Path):
    seen = []
    writer.write(tmp_path / "one", SMALL, progress=lambda *done: seen.append(done))
    writer.write(tmp_path / "two", SMALL, workers=2)
    assert files(tmp_path / "one") == files(tmp_path / "two")
    assert seen == [(1, 3), (2, 3), (3, 3)]
    assert header(tmp_path / "one").families["few"].about == "Three impacts."


def interrupt(folder: Path, families=SMALL) -> None:
    """Write two cases and no more."""

    def after_two(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        writer.write(folder, families, progress=after_two)
    assert not (folder / "few.jsonl").exists()


@pytest.fixture
def solved(monkeypatch) -> list[str]:
    """The ids of the cases that are solved."""
    ids = []
    monkeypatch.setattr(writer, "make", lambda *args: ids.append(args[1].scene.id) or made(*args))
    return ids


def test_an_interrupted_run_goes_on_where_it_stopped(tmp_path: Path, solved: list[str]):
    writer.write(tmp_path / "whole", SMALL)
    interrupt(tmp_path / "halves")
    solved.clear()
    writer.write(tmp_path / "halves", SMALL)
    assert solved == ["impact-0002"]
    assert files(tmp_path / "whole") == files(tmp_path / "halves")
    assert not (tmp_path / "halves" / PARTIAL).exists()


def test_what_other_code_has_left_behind_is_not_used(
    tmp_path: Path, solved: list[str], monkeypatch
):
    with monkeypatch.context() as other_code:
        other_code.setattr(writer, "fingerprint", lambda: "another fingerprint")
        interrupt(tmp_path)
    solved.clear()
    writer.write(tmp_path, SMALL)
    assert solved == ["impact-0000", "impact-0001", "impact-0002"]


def test_a_case_whose_scene_changed_is_solved_again(tmp_path: Path, solved: list[str]):
    first, *others = FEW.cases
    heavier = first.model_copy(update={"scene": replaced(first.scene, {"ball.mass": 0.15})})
    interrupt(tmp_path, {"few": Drafts("", [heavier, *others])})
    solved.clear()
    writer.write(tmp_path, SMALL)
    assert solved == ["impact-0000", "impact-0002"]


def test_families_that_are_not_asked_for_stay(tmp_path: Path, solved: list[str]):
    others = Drafts("Two more.", IMPACTS[3:5])
    interrupt(tmp_path)
    writer.write(tmp_path, {"others": others})
    assert (tmp_path / PARTIAL / "few").is_dir()
    solved.clear()
    # A family that the header does not know yet is read as its file has it.
    writer.write(tmp_path, SMALL | {"others": others}, only=["few"])
    assert solved == ["impact-0002"]
    assert not (tmp_path / PARTIAL).exists()
    assert [len(load(name, tmp_path)) for name in ("few", "others")] == [3, 2]


def test_a_line_may_hold_what_is_written_of_a_case_and_no_more(tmp_path: Path):
    writer.write(tmp_path, SMALL)
    line, *lines = (tmp_path / "few.jsonl").read_text(encoding="utf-8").splitlines()
    case = json.loads(line)
    assert not {*FOUND} & {*case["flags"]}
    bare = {key: case[key] for key in ("scene", "comment", "flags")} | {"flags": ["wide", "tie"]}
    (tmp_path / "few.jsonl").write_text("\n".join([json.dumps(bare), *lines]), encoding="utf-8")
    few = drafts(tmp_path)["few"]
    assert few == Drafts("Three impacts.", [few.cases[0], *FEW.cases[1:]])
    assert few.cases[0] == FEW.cases[0].model_copy(update={"flags": ("tie",)})


# --- checking -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("small")
    writer.write(folder, SMALL)
    seen = []
    assert check(folder, progress=lambda *done: seen.append(done)).failures == ()
    assert seen == [(1, 3), (2, 3), (3, 3)]
    return folder


@pytest.fixture
def small(written: Path, tmp_path: Path) -> Path:
    """A set of three cases, to be changed."""
    return shutil.copytree(written, tmp_path, dirs_exist_ok=True)


def spoil(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_a_changed_value_is_found_by_checksum_by_double_and_by_solving(small: Path):
    case = load("few", small)[1]
    value = case.expected.impact.impulse.value
    digit = "1" if value[12] != "1" else "2"
    spoil(small / "few.jsonl", value, value[:12] + digit + value[13:])
    failures = check(small).failures
    assert any("few.jsonl: its SHA-256 is not the one" in sentence for sentence in failures)
    double = case.quantities["impact.impulse"].double
    assert any(
        sentence.startswith(f"{case.id}, impact.impulse: double={double!r} ")
        for sentence in failures
    )
    assert any(
        sentence.startswith(f"{case.id}: impact.impulse is {value[:12]}{digit}")
        for sentence in failures
    )
    assert any("Gauss-Legendre" in sentence for sentence in failures)


def test_a_changed_last_digit_is_found_by_the_proof_alone(small: Path):
    case = load("few", small)[0]
    value = case.expected.impact.impulse.value
    digit = (int(value[-3]) + 5) % 10
    spoil(small / "few.jsonl", value, f"{value[:-3]}{digit}{value[-2:]}")
    failures = check(small, independent=False).failures
    assert any(
        sentence.startswith(f"{case.id}: impact.impulse is {value[:-3]}{digit}")
        for sentence in failures
    )


@pytest.mark.parametrize(
    ("radius", "other", "apart"),
    [(None, None, True), ("0.1", None, True), (None, "0.1", True), ("0.3", "0.3", False),
     ("0.6", None, False), (None, "0.6", False)],
)  # fmt: skip
def test_enclosures_half_a_unit_apart_overlap_if_their_radii_add_up_to_it(radius, other, apart):
    expected = made("few", FEW.cases[0]).expected

    def at(value: str, radius: str | None) -> Result:
        impulse = Bounded(value=value, radius=radius)
        impact = expected.impact.model_copy(update={"impulse": impulse})
        return expected.model_copy(update={"impact": impact})

    assert bool([*_apart(at("1.5", radius), at("1.0", other))]) is apart


@pytest.mark.parametrize(
    ("file", "old", "new", "sentence"),
    [
        (CHECKSUMS, "few.jsonl", "fow.jsonl", "fow.jsonl: listed in SHA256SUMS, but not there"),
        (CHECKSUMS, "few.jsonl", "fow.jsonl", "few.jsonl: not listed in SHA256SUMS"),
        (CHECKSUMS, "few.jsonl", "../few.jsonl", "SHA256SUMS: '../few.jsonl' is not a file of"),
        (
            "header.json",
            '"few.jsonl"',
            '"../few.jsonl"',
            "header.json: '../few.jsonl' is not",
        ),
        ("few.jsonl", '"flags":[]', '"flags":["odd"]', "the flag odd is not explained"),
        ("few.jsonl", '"level":"lower"', '"level":"mild"', "few.jsonl, line 1: level: "),
        ("few.jsonl", '"family":"few"', '"family":"many"', "says that its family is many"),
        ("few.jsonl", '"id":"impact-0000"', '"id":"impact-0001"', "the id is given twice"),
        ("few.jsonl", '"hex":"0x1', '"hex":"-0x1', "hex='-0x1"),
        ("few.jsonl", '"digits":', '"digits":1', ": double="),
        ("header.json", '"cases": 3', '"cases": 4', "few.jsonl: has 3 cases, 4 in header.json"),
        ("header.json", '"title"', '"titel"', "header.json: title: Field required"),
        ("case.schema.json", "difficulty", "ease", "not the schema that this version"),
    ],
)
@pytest.mark.sampled(every=2)
def test_what_is_wrong_is_said_in_a_sentence(small: Path, file, old, new, sentence):
    spoil(small / file, old, new)
    assert any(sentence in failure for failure in check(small, sample=0).failures)


def test_swapped_lines_are_named(small: Path):
    first, second, third = (small / "few.jsonl").read_text(encoding="utf-8").splitlines()
    lines = "".join(f"{line}\n" for line in (first, third, second))
    write_files(small, {"few.jsonl": lines})  # with its checksum
    assert check(small, sample=0).failures == (
        "impact-0002: stands where impact-0001 belongs",
        "impact-0001: stands where impact-0002 belongs",
    )


def test_a_missing_set_is_said_so(tmp_path: Path):
    assert any("SHA256SUMS: there is no such file" in s for s in check(tmp_path).failures)


# --- probabilities --------------------------------------------------------------------------------


def coarsely(patch: pytest.MonkeyPatch) -> None:
    """Let both methods take few points: they are right to 2e-4 then."""
    patch.setattr("longball.home_run.quadrature.LEVELS", (Nodes(2, 1), Nodes(4, 2)))
    patch.setattr(home_runs, "LINES", 64)


@pytest.fixture(scope="module")
def with_probabilities(tmp_path_factory, written) -> Path:
    """A set of three cases, and P(0.45) of the default reading."""
    folder = shutil.copytree(written, tmp_path_factory.mktemp("set") / "probabilities")
    default, *_ = probabilities().cases
    (row,) = (row for row in default.rows if row.e == 0.45)
    nothing = row.model_copy(update={"p": math.nan})  # what is there is not used
    wanted = default.model_copy(update={"rows": (nothing,)})
    seen = []
    with pytest.MonkeyPatch.context() as patch:
        coarsely(patch)
        assert home_runs.write_probabilities(
            folder,
            [wanted],
            workers=-1,
            progress=lambda *done: seen.append(done),
        )
    assert seen == [(1, 1)]
    return folder


@pytest.mark.nightly
def test_probabilities_come_into_a_set_without_changing_its_other_files(
    with_probabilities: Path, small: Path
):
    alone, together = files(small), files(with_probabilities)
    added = {"probability.json", CHECKSUMS}
    assert {name for name in together if together[name] != alone.get(name)} == added
    # Writing the cases anew keeps them, and their checksum.
    writer.write(with_probabilities, SMALL)
    assert files(with_probabilities) == together


@pytest.fixture
def few_lines(monkeypatch) -> None:
    coarsely(monkeypatch)


@pytest.mark.usefixtures("few_lines")
@pytest.mark.nightly
def test_a_probability_is_computed_again_by_both_methods(with_probabilities: Path):
    report = check(with_probabilities)
    assert report.failures == ()
    assert report.cases == report.solved_again == 4


@pytest.mark.usefixtures("few_lines")
@pytest.mark.nightly
def test_a_wrong_probability_is_found_by_both_methods(with_probabilities: Path):
    (case,) = probabilities(with_probabilities).cases
    (row,) = case.rows
    # By what the quadrature sees, and by 2e-3, which scrambled points see, too.
    for p, count in ((row.p + 2.1 * row.error, 1), (row.p + 2e-3, 3)):
        wrong = case.model_copy(update={"rows": (row.model_copy(update={"p": p}),)})
        sentences = home_runs.integrated_again(wrong, independent=count > 1)
        assert len(sentences) == count
        assert sentences[0].startswith("probability-default, e = 0.45: P is 0.01")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('"slope"', '"slop"', "probability.json: cases.0.rows.0.slope: Field required"),
        (
            '"id": "probability-default"',
            '"id": "impact-0000"',
            "impact-0000: the id is given twice",
        ),
        ("0.01", "0.02", "probability.json: its SHA-256 is not the one"),
    ],
)
@pytest.mark.nightly
def test_what_is_wrong_with_probabilities_is_said(
    with_probabilities: Path, tmp_path: Path, old: str, new: str, sentence: str
):
    shutil.copytree(with_probabilities, tmp_path, dirs_exist_ok=True)
    spoil(tmp_path / "probability.json", old, new)
    assert any(sentence in failure for failure in check(tmp_path, sample=0).failures)


# --- the means ------------------------------------------------------------------------------------


def test_an_outcome_that_an_ulp_decides_is_fragile():

    text = (
        '{"id":"x","kind":"impact","swing":{"angular_speed":0},"incoming":'
        '{"position":[0.0696,%r,1],"velocity":[-40,0,0],"bat_height":1}}'
    )
    for y, fragile in ((0.4999999999999999, True), (0.4, False)):
        scene = parse_scene(text % y)
        found = sensitivity(scene, prove(scene), Enclosure(30))
        assert found.fragile == fragile


def test_smooth_derivatives_are_central_differences_in_doubles():
    """A ball thrown down at 5 m/s from 30 m lands after (-5 + sqrt(25 + 60 g))/g."""
    scene = parse_scene(
        '{"id":"x","kind":"flight","air":null,"gravity":10,'
        '"launch":{"position":[1,2,30],"velocity":[30,1,-5]}}'
    )
    step = 10 * 2.0**-15
    below, above = ((math.sqrt(25 + 60 * g) - 5) / g for g in (10 - step, 10 + step))
    no_engine = None  # of more digits is needed
    found = sensitivity(scene, prove(scene), no_engine).derivatives["landing.hang_time"]
    # A time of 2 s in doubles
    assert found["gravity"] == pytest.approx((above - below) / (2 * step), abs=4 * 2.0**-52 / step)
    assert found["launch.velocity[0]"] == 0.0


def test_a_derivative_that_changes_within_the_step_has_short_steps():
    """A ball dropped from z = 1 mm lands after sqrt(2 z/g); a step in doubles is 7 % of z."""
    scene = parse_scene(
        '{"id":"x","kind":"flight","air":null,"gravity":20,'
        '"launch":{"position":[1,2,0.001],"velocity":[30,1,0]}}'
    )
    found = sensitivity(scene, prove(scene), Enclosure(30)).derivatives["landing.hang_time"]
    assert found["launch.position[2]"] == pytest.approx(5.0, rel=1e-12)  # 1/sqrt(2 g z)


def test_the_attainable_error_of_an_at_bat_counts_the_height_of_the_bat():
    """Half an ulp of each input, of the height of the bat, and of the number itself."""
    case = next(case for case in load("at-bat") if case.expected.contact)
    names = [name for name, _ in numbers_of(case.expected)]
    by = {"pitch.speed": 3.0, "swing.height_offset": -2.0}
    slopes = {path: by.get(path, 0.0) for path in inputs(case.scene)}
    known = Sensitivity(dict.fromkeys(names, slopes), fragile=False)
    found = attainable_errors(case.scene, case.expected, known)
    offset = case.scene.swing.height_offset
    height = float(case.expected.plate.position[2]) + offset
    moved = 3 * case.scene.pitch.speed + 2 * abs(offset) + 2 * abs(height)
    time = float(case.expected.plate.time)
    assert found["plate.time"] == float(f"{2.0**-53 * (moved + time):.3g}")
