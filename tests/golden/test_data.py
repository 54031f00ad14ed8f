"""The golden data as it is shipped: form, checksums, and a sample of it solved again."""

from __future__ import annotations

import json
import math
import re
import zipfile
from decimal import Decimal
from itertools import islice, pairwise
from typing import get_args

import jsonschema
import pytest

from longball import golden
from longball.engines.chain import solve
from longball.engines.enclosure import Enclosure
from longball.golden.case import decisive
from longball.golden.checker import check
from longball.golden.files import CHECKSUMS, HEADER, export, schemas
from longball.golden.reader import DATA, EXTENDED
from longball.home_run import draw, paper_at_bats, scenes, with_restitution
from longball.model.frame import launch_frame
from longball.model.law import law_of
from longball.model.quantities import at, numbers_of, replaced, vector_of
from longball.model.readings import Reading, SamplingReading
from longball.model.result import Outcome
from longball.model.schema import schemas as contract_schemas
from tests import exact
from tests.scenes import all_cases, cases_of

CASES = all_cases()


def test_the_set_is_what_its_files_say_and_a_sample_is_solved_again():
    report = check(sample=5, seed=7)
    assert report.failures == ()
    assert report.solved_again == 5
    assert report.cases == len(CASES) + len(golden.probabilities().cases) >= 500
    confirmed, solved = map(int, re.findall(r"\b[0-9]+\b", report.confirmed)[:2])
    assert solved - 20 < confirmed <= solved == sum(bool(c.expected.outcome) for c in CASES)


def test_lines_obey_the_shipped_schemas():
    for name, content in schemas().items():
        assert (DATA / name).read_text(encoding="utf-8") == content
    case_schema = jsonschema.Draft202012Validator(json.loads(schemas()["case.schema.json"]))
    for family in golden.header().families.values():
        lines = (DATA / family.file).read_text(encoding="utf-8").splitlines()
        for line in lines[:: max(1, len(lines) // 4)]:  # the validator is slow
            case_schema.validate(json.loads(line))
    broken = json.loads(lines[0]) | {"level": "mild"}
    with pytest.raises(jsonschema.ValidationError):
        case_schema.validate(broken)
    jsonschema.validate(
        json.loads((DATA / HEADER).read_bytes()), json.loads(schemas()["header.schema.json"])
    )


def test_the_schemas_have_no_words_but_json_schemas():
    for name, content in (schemas() | contract_schemas()).items():
        data = json.loads(content) if isinstance(content, str) else content
        assert '"discriminator":' not in json.dumps(data), name  # OpenAPI's; strict ajv refuses it
        assert '"type": [' not in json.dumps(data), name  # and so it does a list of types
        jsonschema.Draft202012Validator.check_schema(data)
        assert data["$id"].startswith("urn:longball:schema:")
    case_schema = jsonschema.Draft202012Validator(json.loads(schemas()["case.schema.json"]))
    case = json.loads(CASES[0].line())
    del case["scene"]["kind"]
    assert not case_schema.is_valid(case)


def test_the_quick_cases_are_few_and_of_all_kinds():
    cases = golden.load("quick")
    assert tuple(case.id for case in cases) == golden.header().quick
    assert 20 <= len(cases) <= 60
    assert {case.scene.kind for case in cases} == {"flight", "pitch", "impact", "at-bat"}


def test_a_set_goes_into_one_archive(tmp_path):
    first, second = tmp_path / "a.zip", tmp_path / "b.zip"
    assert (
        export(first, DATA)
        == export(second, DATA)
        == len([path for path in DATA.rglob("*") if path.is_file()])
    )
    assert first.read_bytes() == second.read_bytes()
    with zipfile.ZipFile(first) as archive:
        archive.extractall(tmp_path)
    (folder,) = (path for path in tmp_path.iterdir() if path.is_dir())
    archived, shipped = (
        {path.relative_to(of): path.read_bytes() for path in of.rglob("*") if path.is_file()}
        for of in (folder, DATA)
    )
    assert archived == shipped
    assert golden.header(folder).format in folder.name
    with pytest.raises(ValueError, match="no golden data"):
        export(first, tmp_path)


def test_at_bats_are_the_first_that_are_drawn_from_the_papers_distributions():
    groups: dict[str, list[golden.Case]] = {}
    for case in cases_of("at-bat"):
        groups.setdefault(re.sub(r"-\d{4}$", "", case.id), []).append(case)
    assert len(groups) == 15
    for name, cases in groups.items():
        first, *_ = cases
        said = dict(re.findall(r"(\w+) = ([^,]+)", first.comment))
        switches = {key: said[key] for key in SamplingReading.model_fields if key in said}
        sampling = SamplingReading.model_validate_json(json.dumps(switches), strict=False)
        samples = draw(paper_at_bats(sampling), 10 * len(cases), seed=20261121)
        pitched = filter(lambda pair: pair[1], enumerate(scenes(first.scene, samples)))
        for (i, scene), case in zip(islice(pitched, len(cases)), cases, strict=True):
            drawn = with_restitution(scene, (0.41, 0.42, 0.43, 0.44, 0.45)[i % 5])
            assert drawn.model_copy(update={"id": case.id}) == case.scene
            assert case.id == f"{name}-{i:04d}", case.id


# Numbers that were sought: in which cases, which quantity, of what the comment says how much it is
# off, and the inputs that bring that about.
SOUGHT = (
    ("hard-graze-", "contact.margin", "0", ["swing.height_offset"]),
    ("hard-bat-end-slanted-", "contact.position[1]", "0.5", ["pitch.aim[0]"]),
    ("hard-perpendicular-at-bat-", "contact.normal_speed", "0", ["swing.angular_speed"]),
    ("hard-home-run-flight-", "landing.distance", "150", ["launch.velocity[0]"]),
    ("hard-home-run-at-bat-", "landing.distance", "150", ["swing.angular_speed"]),
    ("impact-oblique-(final-)?(grip|slide)-", "impact.friction_margin", "0", ["bat.friction"]),
    ("fence-(clears|hits)-", "fence.clearance", "0", [f"fence.polyline[{i}][2]" for i in (0, 1)]),
    ("fence-circle-(short|over)", "landing.distance", "150", ["launch.velocity[0]"]),
)


@pytest.mark.parametrize(("ids", "quantity", "of", "inputs"), SOUGHT)
@pytest.mark.sampled(every=7)
def test_numbers_that_were_sought_are_the_nearest_doubles(
    ids: str, quantity: str, of: str, inputs: list[str], nightly: bool
):
    cases = [case for case in CASES if re.match(ids, case.id)]
    assert len(cases) >= 2
    for case in cases if nightly else cases[::4]:
        amount = Decimal(re.search(r"-?1e-\d+|0(?= m$)", case.comment)[0])
        if re.search("hits|inside", case.comment):
            amount = -amount
        x = at(case.scene, inputs[0])

        def miss(
            x: float, scene=case.scene, target: Decimal = Decimal(of) + amount
        ) -> Decimal | None:
            found = solve(replaced(scene, dict.fromkeys(inputs, x)), Enclosure(40))
            value = dict(numbers_of(found)).get(quantity)
            return value and abs(Decimal(value.value) - target)

        beside = [miss(math.nextafter(x, end)) for end in (-math.inf, math.inf)]
        nearest = miss(x)
        assert all(off is None or nearest <= off for off in beside), case.id


def test_radii_are_what_the_header_promises():
    for case in CASES:
        for name, number in numbers_of(case.expected):
            assert number.radius is not None
            size = math.hypot(*(case.quantities[part].double for part in vector_of(name)))
            if name == "contact.margin" and case.scene.kind == "at-bat":
                size = max(size, case.scene.ball.radius + case.scene.bat.radius)
            elif name in ("fence.clearance", "fence.margin"):
                place = vector_of("fence.position[0]")
                size = max(size, math.hypot(*(case.quantities[part].double for part in place)))
            elif name == "impact.friction_margin":
                size = max(1.0, size)
            allowed = Decimal("1.001e-30") * Decimal(size)
            if case.quantities[name].double == 0.0:
                allowed = max(allowed, Decimal("1e-30"))
            assert Decimal(number.radius) <= allowed, (case.id, name)
            assert len(number.value.lstrip("-0.").replace(".", "").split("E")[0]) <= 31


def test_the_independent_method_agrees():
    compared = [case for case in CASES if case.confirmation.agreement is not None]
    assert all(case.expected.outcome == case.confirmation.outcome for case in compared)
    assert max(case.confirmation.agreement for case in compared) < 1.0
    alone = {case.id for case in CASES if case.expected.outcome} - {case.id for case in compared}
    assert alone == {case.id for case in CASES if "unconfirmed" in case.flags}


def test_real_baseball_has_many_cases_all_proven_and_confirmed():
    for family in EXTENDED:
        few = family in ("hard-real", "defaults", "various-real")  # test no law of their own
        assert len(cases_of(family)) >= (30 if few else 40)
        assert not any({"unconfirmed", "wide"} & {*case.flags} for case in cases_of(family))


def test_all_outcomes_and_every_reading_that_matters_are_there():
    assert {case.expected.outcome for case in CASES} == {*get_args(Outcome), None}
    used = {
        (switch, value)
        for case in CASES
        for switch, value in case.scene.reading.model_dump().items()
    }
    assert {switch for switch, _ in used} == set(Reading.model_fields)
    assert {value for switch, value in used if switch == "inertia"} == {"thin_rod", "about_centre"}


def test_what_cannot_be_told_says_why():
    for case in CASES:
        no_answer = {"undecided", "refused"} & set(case.flags)
        assert bool(no_answer) == (case.expected.outcome is None)
        assert bool(no_answer) == (case.expected.error is not None)
        assert bool(no_answer) == (case.expected.code is not None)


# --- conditions -----------------------------------------------------------------------------------


def test_a_graze_loses_half_the_digits_of_its_margin():
    errors = [
        next(case for case in CASES if case.id == f"hard-graze-plus-1e-{power:02d}").attainable(
            "landing.distance"
        )
        for power in (7, 9, 11, 13, 15)
    ]
    # Each hundredth of the margin is a tenth of the chord: ten times the error.
    for one, next_one in pairwise(errors):
        assert next_one / one == pytest.approx(10, rel=0.1)


def test_derivatives_of_a_parabola_are_those_of_its_formula():
    for case in cases_of("flight-vacuum")[:8]:
        scene = case.scene
        assert scene.kind == "flight"
        vz = scene.launch.velocity[2]
        fall = scene.launch.position[2] - scene.ground.height
        root = math.sqrt(vz * vz + 2 * scene.gravity * fall)
        time = case.condition.derivatives["landing.time"]
        assert time["launch.velocity[2]"] == pytest.approx(
            (1 + vz / root) / scene.gravity, rel=6e-3
        )
        assert time["launch.position[2]"] == pytest.approx(1 / root, rel=6e-3)
        assert case.condition.rates == {"landing": pytest.approx(root, rel=6e-3)}


def test_every_decisive_quantity_has_a_derivative_by_every_input():
    for case in CASES:
        if case.condition is not None:
            assert set(case.condition.derivatives) == set(decisive(case.expected))
        if case.expected.outcome == "batted":
            derivatives = case.condition.derivatives["landing.distance"]
            thrown = "pitch.speed" if case.scene.pitch.velocity is None else "pitch.velocity[0]"
            assert {thrown, "bat.mass", "ball.restitution", "gravity"} <= set(derivatives)
            assert set(case.condition.rates) == {"plate", "contact", "landing"}


# --- closed forms ---------------------------------------------------------------------------------


def closed_form(case: golden.Case):
    """Time and state of the landing in elementary functions, in ball arithmetic."""
    scene, numbers = case.scene, Enclosure(40).numbers
    position = [numbers.exact(x) for x in scene.launch.position]
    velocity = [numbers.exact(v) for v in scene.launch.velocity]
    frame, start = launch_frame(tuple(position), tuple(velocity), numbers)
    strengths = law_of(scene, frame, numbers).strengths
    drag, lift, gravity = (strengths.get(name) for name in ("drag", "lift", "gravity"))
    floor = numbers.exact(scene.ground.height)
    if gravity is None:  # the time is the file's: is the place?
        time = numbers.exact(1.0) * flint_ball(case.expected.landing.time)
        return exact.Moment(time, exact.weightless(start, drag, lift, time, exact.METHODS))
    if drag is None and lift is None:
        return exact.parabola_to_floor(start, gravity, floor, exact.METHODS)
    if start.w > 0:
        top = exact.apex(start, drag, gravity, exact.METHODS)
        down = exact.fall_to_floor(top.state, drag, gravity, floor, exact.METHODS)
        return exact.Moment(top.time + down.time, down.state)
    return exact.fall_to_floor(start, drag, gravity, floor, exact.METHODS)


def flint_ball(number):
    import flint

    return flint.arb(number.value, number.radius)


@pytest.mark.parametrize("family", ["flight-vacuum", "flight-vertical", "flight-weightless"])
def test_closed_forms_lie_inside_the_enclosures(family: str):
    for case in cases_of(family):
        with Enclosure(40).numbers.arithmetic():
            moment = closed_form(case)
            landing = case.expected.landing
            pairs = [
                (moment.time, landing.time),
                (moment.state.z, landing.position[2]),
                (moment.state.w, landing.velocity[2]),
            ]
            for closed, enclosed in pairs:
                assert flint_ball(enclosed).overlaps(closed), case.id
                assert closed.rad() < 1e-25


# --- histories ------------------------------------------------------------------------------------


def test_histories_start_at_the_launch_and_end_before_the_landing():
    names = golden.header().histories
    assert len(names) >= 5
    for name in names:
        head, *rows = (DATA / name).read_text(encoding="utf-8").splitlines()
        assert head == "time_s,x_m,y_m,z_m,vx_m_per_s,vy_m_per_s,vz_m_per_s"
        case = next(case for case in CASES if name == f"histories/{case.id}.csv")
        table = [[float(x) for x in row.split(",")] for row in rows]
        launch = case.scene.launch
        assert table[0] == [0.0, *launch.position, *launch.velocity]
        assert [row[0] for row in table] == [float(f"{i * 0.05:.2f}") for i in range(len(table))]
        assert 0 <= float(case.expected.landing.time) - table[-1][0] < 0.05
        assert len(table) > 20


# --- reading --------------------------------------------------------------------------------------


def test_the_set_is_small_and_its_checksums_are_those_of_sha256sum():
    assert sum(path.stat().st_size for path in DATA.rglob("*") if path.is_file()) < 10_000_000
    for line in (DATA / CHECKSUMS).read_text(encoding="utf-8").splitlines():
        digest, name = line.split("  ")
        assert len(digest) == 64
        assert (DATA / name).is_file()
