"""Values counted from elsewhere, made by other formulas, or left out of a force."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from longball.engines.ivp import Ivp
from longball.judge.cases import Case, solved
from longball.judge.formulas import FORMULAS, View
from longball.judge.stages import with_values
from longball.model.aerodynamics import DRAG
from longball.model.air import Air, WindAbove
from longball.model.force import Force, scaled
from longball.model.scene import FlightScene, Launch
from tests.judge.material import at_bats, flights, impacts, pitches
from tests.judge.test_changed_laws import earth, explained, gold, same, with_term
from tests.judge.test_limits import family, in_vacuum, named, thrown
from tests.judge.test_other_numbers import findings
from tests.judge.test_reasons import result, told

Given = dict[str, Any]


def many_impacts() -> list[Case]:
    scenes = [
        with_values(s, {"id": f"{s.id}-{m:g}", "ball.mass": m, "ball.restitution": 0.3 + m})
        for s in impacts() for m in (0.1, 0.145, 0.2)
    ]  # fmt: skip
    return solved(scenes, Ivp())


def ratio(scene: Any, given: Given) -> float:
    """Return m/M_eff, of ẽ = e + (1 + e) m/M_eff."""
    e = scene.ball.restitution
    return float((given["impact"]["restitution"] - e) / (1 + e))


# --- values in the result -------------------------------------------------------------------------


def from_axis(scene: Any, given: Given) -> None:
    if "position" in given.get("contact", {}):
        axis = given["plate"]["position"][2] + scene.swing.height_offset
        given["contact"]["position"][2] -= axis


def share(scene: Any, given: Given) -> None:
    if "contact" in given:
        given["contact"]["margin"] /= scene.ball.radius + scene.bat.radius


def from_aim(scene: Any, given: Given) -> None:
    if "plate" in given:
        given["plate"]["position"][2] -= scene.pitch.aim[1]


@pytest.mark.parametrize(
    ("name", "change", "stage"),
    [
        (
            "contact.position: the height above the bat's axis",
            from_axis,
            "touching",
        ),
        ("contact.margin: the margin as a share of R + r_b", share, "touching"),
        ("plate.position: the height above that aimed at", from_aim, "pitch"),
    ],
)
def test_a_place_or_a_margin_of_another_kind(name, change, stage):
    assert named(solved(at_bats(40), Ivp()), change, stage).names[0] == name


def test_a_landing_counted_from_the_launch():
    def from_launch(scene: Any, given: Given) -> None:
        place = np.array(given["landing"]["position"]) - scene.launch.position
        given["landing"]["position"] = place.tolist()

    assert named(solved(flights(), Ivp()), from_launch, "flight").names == [
        "landing.position: the way from the launch"
    ]


def straight(scene: Any, landing: Given) -> float:
    return math.dist(landing["position"], scene.launch.position)


def by_landing_speed(scene: Any, landing: Given) -> float:
    return float(landing["hang_time"] * np.linalg.norm(landing["velocity"]))


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("landing.path: the straight way", straight),
        ("landing.path: the way at the landing's speed", by_landing_speed),
    ],
)
def test_a_path_by_another_formula(name, path):
    def other(scene: Any, given: Given) -> None:
        if "path" in given["landing"]:
            given["landing"]["path"] = path(scene, given["landing"])

    assert named(family("flight-spin-decay"), other, "spin decay").names == [name]


def per_mass(scene: Any, given: Given) -> None:
    given["impact"]["impulse"] /= scene.ball.mass


def loss_squared(scene: Any, given: Given) -> None:
    e = given["impact"]["restitution"]
    given["impact"]["energy_change"] *= (1 - e) / (1 + e)


def of_whole_speed(scene: Any, given: Given) -> None:
    contact = given["contact"]
    speed = math.dist(scene.incoming.velocity, contact["bat_velocity"])
    given["impact"]["energy_change"] *= (speed / contact["normal_speed"]) ** 2


def without_one(scene: Any, given: Given) -> None:
    r = ratio(scene, given)
    given["impact"]["restitution"] = scene.ball.restitution * r + r


def small_angle(scene: Any, given: Given) -> None:
    x, y, z = given["contact"]["normal"]
    given["contact"]["normal"] = [math.copysign(1.0, x), y, z]


def against(scene: Any, given: Given) -> None:
    velocity = np.array(scene.incoming.velocity)
    given["contact"]["normal"] = (-velocity / np.linalg.norm(velocity)).tolist()


@pytest.mark.parametrize(
    ("name", "change", "stage"),
    [
        ("impact.impulse: μ = μ/m", per_mass, "impulse"),
        ("impact.energy_change: 1 - ẽ² = (1 - ẽ)²", loss_squared, "energy"),
        ("impact.energy_change: Ṽ·n = |Ṽ|", of_whole_speed, "energy"),
        (
            "impact.restitution: e m/M_eff + m/M_eff, without the 1",
            without_one,
            "restitution",
        ),
        ("contact.normal: 1 for its cosine", small_angle, "normal"),
        ("contact.normal: against the velocity", against, "normal"),
    ],
)
def test_another_formula_of_the_impact(name, change, stage):
    assert named(many_impacts(), change, stage).names == [name]


def test_a_vector_that_is_added():
    def added(scene: Any, given: Given) -> None:
        given["contact"]["bat_velocity"][0] += 0.5
        given["contact"]["bat_velocity"][2] -= 0.25

    only = named(many_impacts(), added, "bat velocity")
    assert only.sentence == "contact.bat_velocity: obtained = expected + (0.5, 0, -0.25)"


def test_a_restitution_that_falls_with_the_speed():
    def slower(scene: Any, given: Given) -> None:
        speed = -given["contact"]["normal_speed"]
        r, e = ratio(scene, given), scene.ball.restitution - 0.002 * (speed - 25)
        given["impact"]["restitution"] = e + (1 + e) * r

    only = named(many_impacts(), slower, "restitution")
    assert "falls with the speed: by 0.002 for each m/s above 25 m/s" in only.sentence


@pytest.mark.parametrize(("square", "number"), [("length", 0.5), ("radius", 0.5)])
def test_another_number_in_the_moment_of_inertia(square, number):
    usual = {"length": 1 / 3, "radius": 1 / 4}

    def other(scene: Any, given: Given) -> None:
        parts = {"length": scene.bat.length**2, "radius": scene.bat.radius**2}
        right = sum(usual[name] * part for name, part in parts.items())
        wrong = right + (number - usual[square]) * parts[square]
        r, e = ratio(scene, given) * right / wrong, scene.ball.restitution
        given["impact"]["restitution"] = e + (1 + e) * r

    only = named(many_impacts(), other, "restitution")
    assert f"has {number} {'L²' if square == 'length' else 'r_b²'} for the bat's" in only.sentence


@pytest.mark.parametrize(
    ("name", "velocity"),
    [
        ("contact.normal_speed: V = (V_x, V_y, 0)", lambda scene, before: [*before[:2], 0.0]),
        ("contact.normal_speed: V = the release's speed", lambda scene, before: (
            np.array(before) * (np.linalg.norm(scene.pitch.thrown) / np.linalg.norm(before))
        ).tolist()),
    ],
)  # fmt: skip
def test_a_velocity_that_is_not_that_of_the_contact(name, velocity):
    def other(scene: Any, given: Given) -> None:
        if "normal_speed" not in given.get("contact", {}):
            return
        contact = given["contact"]
        _, before = thrown(scene, contact["time"])
        closing = np.array(velocity(scene, before)) - contact["bat_velocity"]
        contact["normal_speed"] = float(closing @ np.array(contact["normal"]))
        given.pop("impact", None)
        given.pop("landing", None)

    # In vacuum a velocity keeps its level part.
    assert name in named(in_vacuum(at_bats(40)), other, "normal speed").names


def test_a_unit_in_grazes_is_read_as_everywhere_else():
    def in_mph(scene: Any, given: Given) -> None:
        if "velocity" in given.get("impact", {}):
            given["impact"]["velocity"] = [x / 0.44704 for x in given["impact"]["velocity"]]

    cases = family("hard", lambda s: s.kind == "at-bat")

    def answer(i: int, case: Case) -> Given:
        given = result(case.scene)
        in_mph(case.scene, given)
        return given

    assert [f.stage for f in told(cases, answer)] == ["velocity after"]


# --- what the chain begins with -------------------------------------------------------------------


def from_elsewhere(place: Callable[[Any, list[float]], Iterable[float]]) -> Any:
    """Return the change of a result to one whose batted ball flies from another place."""

    def change(scene: Any, given: Given) -> None:
        if "impact" not in given or "landing" not in given:
            return
        height = given["plate"]["position"][2] + scene.swing.height_offset
        start = tuple(place(height, given["contact"]["position"]))
        launch = Launch(position=start, velocity=tuple(given["impact"]["velocity"]))
        landing = result(FlightScene(id=scene.id, launch=launch, air=scene.air))["landing"]
        landing["time"] = given["contact"]["time"] + landing["hang_time"]
        given["landing"] = landing

    return change


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("batted-above-origin", lambda height, p: (0.0, 0.0, p[2])),
        ("batted-from-bat-axis", lambda height, p: (0.0, p[1], height)),
    ],
)
def test_a_batted_ball_that_flies_from_elsewhere(name, place):
    assert named(solved(at_bats(40), Ivp()), from_elsewhere(place), "flight").names[0] == name


def test_an_aim_on_the_other_side_is_no_exchange_of_axes():
    def mirrored(scene: Any) -> Any:
        y, z = scene.pitch.aim
        return with_values(scene, {"pitch.aim": (-y, z)})

    first, *others = findings(solved(pitches() + thrown_aside(), Ivp()), mirrored)
    assert "pitch.aim[0]*-1" in first.names
    assert not others


def thrown_aside() -> list[Any]:
    """Return pitches from beside the middle, most of which are aimed at it."""
    return [with_values(s, {"id": f"{s.id}-{y}-{aim}", "pitch.release[1]": y, "pitch.aim[0]": aim})
            for s in pitches() for y in (0.3, 0.6) for aim in (0.0, 0.2)]  # fmt: skip


def test_an_aim_at_the_front_of_the_plate():
    def farther(scene: Any) -> Any:
        (x, *beside), aim = scene.pitch.release, scene.pitch.aim
        there = tuple(b + (a - b) * x / (x - 0.4318) for a, b in zip(aim, beside, strict=True))
        return with_values(scene, {"pitch.aim": there})

    assert findings(solved(thrown_aside(), Ivp()), farther)[0].names == ["aim-at-front"]


@pytest.mark.parametrize(
    ("name", "sign", "turn"), [("from-east", 1, 90), ("from-south", 1, 180), ("sign", -1, 0)]
)
def test_an_azimuth_from_another_direction(name, sign, turn):
    other = earth(azimuth=lambda angle: sign * angle + math.radians(turn))
    assert explained(gold("flight-real", 2), other) == [f"azimuth-{name}"]


def test_usual_air_for_none():
    empty = [s.model_copy(update={"id": f"{s.id}-empty", "air": None}) for s in flights()]

    def filled(scene: Any) -> Any:
        return scene.model_copy(update={"air": Air()}) if scene.air is None else scene

    assert findings(solved([*empty, *flights()], Ivp()), filled)[0].names[0] == "air-for-null"


def test_numbers_read_with_few_decimals():
    def short(scene: Any) -> Any:
        (x, y, z), (u, v, w) = scene.launch.position, scene.launch.velocity
        named = {"launch.position": (x, y, z), "launch.velocity": (u, v, w)}
        rounded = {n: tuple(round(c, 2) for c in value) for n, value in named.items()}
        ball = {f"ball.{n}": round(getattr(scene.ball, n), 2) for n in ("mass", "radius")}
        return with_values(scene, rounded | ball)

    assert findings(solved(flights(), Ivp()), short)[0].names[0] == "read-to:2 decimals"


# --- the law --------------------------------------------------------------------------------------


def test_a_drag_without_its_part_across():
    """In a wind across flights along x, whose frame has the axes of the scene."""
    scenes = [
        with_values(s, {"launch.velocity": (math.hypot(*s.launch.velocity[:2]), 0.0,
                                            s.launch.velocity[2]), "air.wind": (1.0, 6.0, 0.0)})
        for s in flights()
    ]  # fmt: skip

    def level(m: Any, p: Any) -> Any:
        u, _, w = m.air.velocity
        return scaled(-(m.density * DRAG.rate(m, p)), (u, 0.0 * u, w))

    model = with_term(DRAG, Force(DRAG.parameters, DRAG.strengths, level))
    assert explained(solved(scenes, Ivp()), same, model) == ["drag-without-y"]


def test_a_crisis_whose_numbers_are_taken_for_kilometres_per_hour():
    def slower(scene: Any) -> Any:
        if getattr(scene.air.drag_coefficient, "law", "") != "crisis":
            return scene
        held = scene.air.drag_coefficient
        return with_values(scene, {f"air.drag_coefficient.{key}": getattr(held, key) / 3.6
                                   for key in ("speed", "width")})  # fmt: skip

    assert explained(gold("flight-spin-drag"), slower) == ["air.drag_coefficient-in-km/h"]


def test_a_mistake_in_one_branch_is_told_with_the_scenes_that_it_spares():
    """The spin without its z, but where the reading takes the whole spin."""

    def flat(scene: Any) -> Any:
        if scene.launch.spin is None or scene.reading.spin_parameter == "total":
            return scene
        return with_values(scene, {"launch.spin": (*scene.launch.spin[:2], 0.0)})

    spinning = gold("flight-spin-lift")
    known = [case for case in spinning if case.scene.launch.spin[2] == 0.0]
    assert known or len(spinning) > 30
    told_ = findings(spinning, flat)[0]
    assert told_.names[0] == "spin:(x, y, 0)"
    assert "spin_parameter" in told_.sentence + str(told_.scenes)


def mean(line: Any) -> Any:
    return [(x, y, (p[2] + q[2]) / 2) for p, q in pairwise(line) for x, y, _ in (p, q)]


def without_steps(line: Any) -> Any:
    return [line[0], *(q for p, q in pairwise(line) if p[:2] != q[:2])]


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("fence-height-of-mean", mean),
        ("fence-height-in-feet", lambda line: [(x, y, 0.3048 * z) for x, y, z in line]),
        ("fence-without-steps", without_steps),
    ],
)
def test_a_fence_of_other_heights(name, change):
    def has_line(s: Any) -> bool:
        return s.kind == "flight" and bool(s.fence and s.fence.polyline)

    cases = [*family("fence", has_line), *family("combined", has_line)]

    def other(scene: Any) -> Any:
        return with_values(
            scene, {"fence.polyline": tuple(map(tuple, change(scene.fence.polyline)))}
        )

    only, *_ = (f for f in findings(cases, other) if f.stage == "fence")
    assert only.names[0] == name


# --- events and outcomes --------------------------------------------------------------------------


def test_a_contact_at_the_closest_approach():
    def closest(scene: Any, given: Given) -> None:
        given.pop("impact", None)
        given.pop("landing", None)
        if "position" not in given.get("contact", {}):
            return
        height = given["plate"]["position"][2] + scene.swing.height_offset
        time = given["contact"]["time"]
        for _ in range(60):  # Newton's method for (d·v) = 0
            (x, _, z), (u, _, w) = thrown(scene, time)
            z -= height
            time -= (x * u + z * w) / (u * u + w * w - z * scene.gravity)
        place, _ = thrown(scene, time)
        margin = given["contact"]["margin"]
        given["contact"] = {"time": time, "position": place, "margin": margin}

    only = named(in_vacuum(at_bats(40)), closest, "touching")
    assert only.names == ["touches-closest"]


def test_a_pitch_that_flies_on_below_the_ground():
    def answer(i: int, case: Case) -> Given:
        """Return the pitch 90 m above the ground, lowered by that."""
        pitch = case.scene.pitch
        higher = {"pitch.release[2]": pitch.release[2] + 90, "pitch.aim[1]": pitch.aim[1] + 90}
        given = result(with_values(case.scene, higher))
        if "plate" in given:
            given["plate"]["position"][2] -= 90
        return given

    cases = family("pitch", lambda scene: scene.pitch.velocity is None)
    (found,) = (f for f in told(cases, answer) if "crossed where grounded" in f.sentence)
    assert found.names == ["pitch-without-ground"]


def test_outcomes_that_follow_from_one_thing_are_one_line():
    cases = solved(at_bats(200), Ivp())

    def answer(i: int, case: Case) -> Given:
        offset = case.scene.swing.height_offset + 0.02
        return result(with_values(case.scene, {"swing.height_offset": offset}))

    (only,) = (f for f in told(cases, answer) if f.stage == "outcome")
    assert only.sentence.startswith("says missed where batted is right, batted where missed is")
    assert only.sentence.endswith("this follows from the above")


# --- one value for another ------------------------------------------------------------------------


def plates_time(scene: Any, given: Given) -> None:
    if "time" in given.get("contact", {}):
        given["contact"]["time"] = given["plate"]["time"]


def launchs_velocity(scene: Any, given: Given) -> None:
    if "landing" in given:
        given["landing"]["velocity"] = given["impact"]["velocity"]


def with_radius(scene: Any, given: Given) -> None:
    if "landing" in given:
        given["landing"]["distance"] += scene.ball.radius


@pytest.mark.parametrize(
    ("name", "change", "stage"),
    [
        ("contact.time: plate.time", plates_time, "touching"),
        ("landing.velocity: impact.velocity", launchs_velocity, "landing velocity"),
        ("landing.distance + ball.radius", with_radius, "distance"),
    ],
)
def test_another_value_or_one_more(name, change, stage):
    other = [with_values(s, {"id": f"{s.id}-small", "ball.radius": 0.035}) for s in at_bats(20)]
    assert name in named(solved([*at_bats(20), *other], Ivp()), change, stage).names


def test_a_bat_that_is_a_radius_too_high():
    def higher(scene: Any) -> Any:
        return with_values(scene, {
            "swing.height_offset": scene.swing.height_offset + scene.ball.radius})  # fmt: skip

    other = [with_values(s, {"id": f"{s.id}-small", "ball.radius": 0.03}) for s in at_bats(20)]
    first = findings(solved([*at_bats(20), *other], Ivp()), higher)[0]
    assert first.names == ["bat-high-by-ball.radius"]


def test_a_quantity_that_is_given_later_is_no_other_one_for_an_earlier():
    by_name = {formula.name: formula for formula in FORMULAS}
    given = {"impact.spin": (1.0, 2.0, 3.0), "landing.spin": (4.0, 5.0, 6.0)}
    follows = {f"{name}:follows": tuple(-x for x in value) for name, value in given.items()}
    view = View(None, given | follows, (0.0, 0.0, 0.0), 0.0)
    earlier, later = (by_name[name].value(view) for name in (
        "impact.spin: landing.spin", "landing.spin: impact.spin"))  # fmt: skip
    assert (earlier, later) == (follows["landing.spin:follows"], given["impact.spin"])


@pytest.mark.parametrize(
    ("name", "across"),
    [
        ("V' with its part along the bat's surface reversed", lambda v, bat: -v),
        ("V' with the velocity of the bat along its surface", lambda v, bat: bat),
    ],
)
def test_another_velocity_along_the_bats_surface(name, across):
    def change(scene: Any, given: Given) -> None:
        if "impact" in given:
            n, after, bat = (np.array(x) for x in (
                given["contact"]["normal"], given["impact"]["velocity"],
                given["contact"]["bat_velocity"]))  # fmt: skip
            v, bat = (x - (x @ n) * n for x in (after, bat))
            given["impact"]["velocity"] = [*(after - v + across(v, bat)).tolist()]

    assert named(many_impacts(), change, "velocity after").names == [f"impact.velocity: {name}"]


@pytest.mark.parametrize(
    ("radius", "name"), [(0.0, "touches-at-ball-radius"), (0.02, "touches-at-0.0566 m")]
)
def test_ball_and_bat_touch_at_another_distance(radius: float, name: str):
    """The margins are by the true one."""

    def nearer(scene: Any) -> Any:
        return with_values(scene, {"bat.radius": radius})

    def answer(i: int, case: Case) -> dict[str, Any]:
        right, other = result(case.scene), result(nearer(case.scene))
        if {"time", "position"} <= other.get("contact", {}).keys():
            right["contact"] |= {key: other["contact"][key] for key in ("time", "position")}
        return {key: x for key, x in right.items() if key in ("id", "outcome", "plate", "contact")}

    met = [s for s in at_bats(40) if "position" in result(nearer(s)).get("contact", {})]
    first, *_ = told(solved(met, Ivp()), answer)
    assert first.names == [name]


# --- keys that are misread ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("family", "name", "alter"),
    [
        ("flight-real", "earth.azimuth=0", earth(azimuth=lambda angle: 0.0)),
        ("flight-kinks", "air.wind-everywhere-above", lambda scene: with_values(
            scene, {"air.wind": scene.air.wind.velocity})
            if isinstance(scene.air.wind, WindAbove) else scene),
        ("impact-oblique", "bat.support-ignored", lambda scene: scene.model_copy(
            update={"bat": scene.bat.model_copy(update={"support": None})})),
    ],
)  # fmt: skip
def test_a_key_that_is_ignored(family, name, alter):
    assert name in explained(gold(family), alter)


def test_one_scene_tells_nothing_that_others_contradict():
    """Many a law would explain a single flight."""

    def turned(scene: Any, given: Given) -> None:
        if scene.id == flights()[3].id:
            given["landing"]["position"][1] *= -1
            given["landing"]["velocity"][1] *= -1

    assert named(solved(flights(), Ivp()), turned, "flight").names == []


@pytest.mark.parametrize(
    ("name", "spin"),
    [
        ("batted-without-spin", lambda spin: [0.0, 0.0, 0.0]),
        ("batted-spin-reversed", lambda spin: [-x for x in spin]),
    ],
)
def test_a_batted_ball_with_another_spin(name, spin):
    def change(scene: Any, given: Given) -> None:
        if scene.kind == "at-bat" and "landing" in given:
            impact, contact = given["impact"], given["contact"]
            launch = Launch(
                position=tuple(contact["position"]), velocity=tuple(impact["velocity"]),
                spin=tuple(spin(impact["spin"])),
            )  # fmt: skip
            keys = ("air", "ball", "gravity", "reading", "ground", "time_limit")
            same = {key: getattr(scene, key) for key in keys}
            landing = result(FlightScene(id=scene.id, launch=launch, **same)).get("landing")
            given["landing"]["hang_time"] = landing["hang_time"]
            given["landing"]["time"] = contact["time"] + landing["hang_time"]
            given["landing"] |= {key: landing[key] for key in ("position", "velocity", "distance")}

    assert name in named(gold("at-bat-real"), change, "flight").names
