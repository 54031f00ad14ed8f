"""What is behind other outcomes, and what is told besides numbers and is not so."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from longball.engines.chain import MODEL, solve
from longball.judge.any_law import ANY_LAW
from longball.judge.contact_mistakes import FENCE, OUTCOMES, TIME_LIMIT_IGNORED
from longball.judge.explanations import evenly, told_together
from longball.judge.findings import Finding, found, many
from longball.judge.quantities import OPTIONAL, superfluous, told_by, untrue
from longball.judge.rules import CHANCE, rule
from longball.judge.stages import COLLISION, NONE, Change, Trial, Trials, stage_of
from longball.model.result import Result
from longball.model.scene import FlightScene

WRONG, RIGHT = 8, 4  # wrong outcomes of a kind, and right ones, that an explanation is held against
NEAR = 1e-3  # relative: how near a landing is to that of its explanation, by another integrator
MOST = 0.9  # of wrong outcomes, how many must follow from something for that to be said

# Outcomes that a dip below the ground makes of each other.
DIPS = ({"landed", "airborne"}, {"grounded", "airborne"}, {"grounded", "crossed"})

FINE = 1e-12  # relative: with a value that is off by less, another outcome does not follow from it


def _is_fair(place: Sequence[float]) -> bool:
    return abs(place[1]) <= place[0]


def _leaves(trial: Trial, fair: bool = True) -> bool:
    """Tell whether a ball passes over the fence, by its own values, fair or foul."""
    # Over a fence that is a circle a ball goes fair wherever it does.
    place, above = trial.given.get("fence.position"), trial.given.get("fence.clearance")
    over = place is not None and above is not None and above[0] > 0
    return over and (_is_fair(place or ()) or trial.scene.fence.polyline is None) is fair


def _beyond_limit(trial: Trial) -> bool:
    times = (trial.given.get(name, (0.0,)) for name in ("landing.hang_time", "plate.time"))
    flown = max(time for (time,) in times)
    return trial.case.expected.outcome == "airborne" and bool(flown > trial.scene.time_limit)


def _limited_together(trial: Trial) -> bool:
    if trial.outcome != "airborne" or "landing.time" not in trial.expected:
        return False
    (hang,), (whole,) = trial.expected["landing.hang_time"], trial.expected["landing.time"]
    return bool(hang <= trial.scene.time_limit < whole)


# Mistakes in what counts as which outcome, told by the values of an answer: name, sentence, remedy,
# and whether a trial with another outcome is of that kind.
RULES: tuple[tuple[str, str, str, Callable[[Trial], bool]], ...] = (
    (TIME_LIMIT_IGNORED.name, TIME_LIMIT_IGNORED.sentence, TIME_LIMIT_IGNORED.remedy,
     _beyond_limit),
    ("time-limit-of-both", "counts time_limit for pitch and batted ball together",
     "pitch and batted ball have time_limit seconds each", _limited_together),
    ("pitch-without-ground", "lets a pitch fly on below the ground",
     "a pitch that comes down before the plate is grounded", lambda t: (
         t.case.expected.outcome == "grounded" and "plate.position" in t.given
         and t.given["plate.position"][2] < t.scene.ground.height)),
    ("foul-home-run", "takes a foul ball over the fence for a home run",
     "a ball that passes the fence foul is none: it flies on, and lands",
     lambda t: t.outcome == "home_run" and _leaves(t, fair=False)),
)  # fmt: skip

# What else may be taken for fair: of the place at the fence, or else of the landing, and of that.
FAIR: tuple[tuple[str, str, Callable[[Sequence[float], Sequence[float]], bool]], ...] = (
    ("fair-left-line", "looks at the line on the left only, y ≤ x",
     lambda place, landing: place[1] <= place[0]),
    ("fair-right-line", "looks at the line on the right only, -y ≤ x",
     lambda place, landing: -place[1] <= place[0]),
    ("fair-in-front", "takes for fair whatever is in front of the plate, x > 0",
     lambda place, landing: place[0] > 0),
    ("fair-at-landing", "judges where the ball lands, not where it passes the fence",
     lambda place, landing: _is_fair(landing)),
    ("fair-reversed", "takes foul for fair", lambda place, landing: not _is_fair(place)),
)  # fmt: skip


def _fair_otherwise(trials: Iterable[Trial]) -> tuple[list[str], str] | None:
    """Return what explains all that is told to be fair; None if nothing does."""
    told = []
    for t in trials:
        landing = t.given.get("landing.position")
        if "landing.fair" in t.told and landing is not None:
            told.append((t.told["landing.fair"], t.given.get("fence.position", landing), landing))
    ties = [f for f in FAIR if all(f[2](place, landing) is fair for fair, place, landing in told)]
    if not ties:
        return None
    return [name for name, *_ in ties], told_together([sentence for _, sentence, _ in ties])


ABOVE = "this follows from the above"
FLIES_WRONGLY = "its ball flies wrongly", "see whether this is so still when the flight is right"


def outcome_findings(trials: Trials, base: Change, known: Sequence[Finding]) -> Iterator[Finding]:
    """Yield what is behind the other outcomes of some trials; `known` is what is found already."""
    kinds: dict[tuple[str, str], list[Trial]] = defaultdict(list)
    for t in trials:
        if t.confused:
            kinds[str(t.case.expected.outcome), str(t.outcome)].append(t)
    flies = {f.stage for f in known}.isdisjoint(("pitch", "flight"))
    # What other mistakes make: by their names, what is said of it and its remedy.
    following: dict[tuple[Any, ...], dict[str, list[Trial]]] = defaultdict(dict)
    for (expected, obtained), wrong in sorted(kinds.items(), key=lambda k: -len(k[1])):
        agreed = [t for t in trials if not t.confused]
        same = [t for t in agreed if t.case.expected.outcome == expected]
        held = [*evenly(same, RIGHT), *evenly([t for t in agreed if not t.right], RIGHT)]
        what, remedy = f"{obtained} where {expected} is right", None
        sentence = f"says {what}"
        names, own, against = list[str](), "", ""
        if limit := _limit(obtained, wrong, trials):
            own = sentence = f"{sentence}: {limit}"
        elif against := _against_itself(wrong):
            sentence += f", against {against}"
        elif made := _made(evenly(wrong, WRONG), held, agreed, base, known):
            names, said = made
            if not said:
                following[tuple(names), ABOVE, None][what] = wrong
                continue
            sentence += f": {said}"
        elif own := _follows(wrong):
            following[(), own, None][what] = wrong
            continue
        elif rule_ := next((r for r in RULES if flies and all(map(r[3], wrong))), None):
            name, said, remedy, _ = rule_
            names, sentence = [name], f"{sentence}: {said}"
        elif obtained in ("landed", "batted") and all(
            "fence" in _blocks(t.expected) - _blocks(t.given) for t in wrong
        ):
            sentence += ", and gives no block fence: where the ball passes it is not seen"
        elif (
            obtained == "missed"
            and expected in ("batted", "separating", "beyond_bat")
            and not {f.stage for f in known} & {"pitch", "plate", "touching"}
        ):
            sentence += ": as one who looks for the bat at the steps only"
            remedy = "find the closest approach within the step, where d·v changes sign, and test "
            remedy += "there"
        elif flies and {expected, obtained} in DIPS and all("dip" in t.case.flags for t in wrong):
            own = "as one whose flight is off by more than the ball dips below the ground, or who "
            own += "looks for it at the steps only"
            sentence += f": {own}"
            remedy = "find the lowest point within the step, where v_z changes sign, and test there"
        elif not flies:
            following[(), *FLIES_WRONGLY][what] = wrong
            continue
        one = _told("outcome", "outcome", names, sentence, wrong, same)
        more: dict[str, Any] = {"kind": "unexplained", "remedy": remedy, "example": None}
        if names or own or against:
            more |= {"kind": "probably", "share": 1.0, "scenes": None}
        yield one.model_copy(update=more)
    for (named, reason, remedy), flown in following.items():
        whole = [t for wrong in flown.values() for t in wrong]
        said = f"says {', '.join(flown)}, in {many(len(whole), 'scene')}: {reason}"
        one = _told("outcome", "outcome", [*named], said, whole, [])
        more = {"kind": "probably", "share": 1.0, "remedy": remedy}
        yield one.model_copy(update=more | {"scenes": None, "example": None})


def _made(
    wrong: Trials, same: Trials, agreed: Trials, base: Change,
    known: Sequence[Finding]
) -> tuple[list[str], str] | None:  # fmt: skip
    """Return names and sentence of what makes these outcomes, and those `agreed` on.

    What is known makes them without a sentence.
    """
    whole = [*wrong, *same]

    def makes(change: Change) -> bool:
        concerned = [t for t in agreed if change.scene(t.scene) != t.scene]
        tells = []
        for t in (*whole, *evenly(concerned, RIGHT)):
            if (one := _explains(change, t)) is False:
                return False
            tells.append(one)
        return True in tells[: len(wrong)]

    named = [name for f in known for name in f.names[:1] if f.stage != "outcome"]
    if named and base is not NONE and makes(base):
        return named[:1], ""
    if base is not NONE and all(_explains(base, t) for t in wrong):
        return None  # nothing else is behind these, though something is left of other trials
    clear = any("home_run" in (t.outcome, t.case.expected.outcome) for t in whole) and not any(
        "fence.clearance" in t.given for t in whole
    )
    ties = [m for m in (*OUTCOMES, *(FENCE if clear else ())) if makes(base.then(m.change))]
    if not ties:
        return None
    return [m.name for m in ties], told_together([m.sentence for m in ties])


MOST_STEPS = 10_000  # of one flight by a scheme, to see how it ends


def _explains(change: Change, trial: Trial) -> bool | None:
    """Tell whether a change makes a trial's outcome, and a landing near to its own."""
    # None where doubles do not decide it, or a scheme takes very many steps to it.
    scenes = trial.scene, change.scene(trial.scene)
    own, changed = (getattr(scene, "time_limit", 0.0) for scene in scenes)
    if own < changed > MOST_STEPS * getattr(change.engine, "dt", math.inf):
        return None
    try:
        result = _solved(trial, change)
    except (ArithmeticError, ValueError):
        return False
    if result.outcome is None:
        return None
    if result.outcome != (trial.outcome or trial.case.expected.outcome):
        return False
    said = trial.given.get("landing.position")
    if said is None or result.landing is None:
        return True
    there = tuple(map(float, result.landing.position))
    return math.dist(there, said) <= NEAR * max(1.0, math.hypot(*there))


def _solved(trial: Trial, change: Change) -> Result:
    return solve(change.scene(trial.scene), change.engine, change.model(MODEL))


def made_otherwise(trial: Trial, change: Change, facts: Mapping[str, object]) -> bool:
    """Tell whether a change would make something else of what is told besides numbers."""
    try:
        made = told_by(_solved(trial, change))
    except (ArithmeticError, ValueError):
        return False
    return any(made.get(name) != told for name, told in facts.items())


# Outcomes that are told by how low a value is, m: its name, up to the sign; its limit; the value;
# whether the outcome is right by it.
LIMITED: dict[
    str, tuple[str, str, Callable[[Trial], float | None], Callable[[Trial], bool]]
] = {
    "missed": ("contact.margin", "0", lambda t: t.given.get("contact.margin", (None,))[0],
               lambda t: t.given["contact.margin"][0] <= 0),
    "wall": ("fence.clearance", "0", lambda t: t.given.get("fence.clearance", (None,))[0],
             lambda t: t.given["fence.clearance"][0] <= 0),
    "beyond_bat": ("|contact.position[1]|", "L/2", lambda t: (
        -abs(t.given["contact.position"][1]) if "contact.position" in t.given else None),
        lambda t: _beyond(t)),
}  # fmt: skip


def _limit(obtained: str, wrong: Trials, trials: Trials) -> str:
    """Return between which of their own values an outcome's limit lies; nothing if it is right."""
    if obtained not in LIMITED:
        return ""
    name, right, value, rightly = LIMITED[obtained]
    wrongly = [x for t in wrong if (x := value(t)) is not None]
    told = [x for t in trials if t.outcome == obtained and (x := value(t)) is not None]
    others = [x for t in trials if t.outcome != obtained and (x := value(t)) is not None]
    chosen = math.comb(len(wrongly) + len(others), len(wrongly))  # as many might be the lowest
    if len(wrongly) < len(wrong) or chosen < CHANCE or max(told) >= min(others):
        return ""
    if all(map(rightly, wrong)):
        return ""  # by its own values it is that outcome
    low, high = sorted((abs(max(told)), abs(min(others))))
    return f"its limit for {name} is between {low:.3g} and {high:.3g} m, where {right} is right"


def _against_itself(trials: Trials) -> str:
    """Return which of their own values wrong outcomes contradict, with what it says; else ""."""
    for quantity, beyond, within, says in (
        ("fence.clearance", {"home_run"}, {"wall"}, "above the fence"),
        ("contact.margin", {"batted", "separating"}, {"missed"}, "nearer than the bat's surface"),
    ):
        given = [(t, t.given[quantity][0] > 0) for t in trials if quantity in t.given]
        if given and all(t.outcome in (within if above else beyond) for t, above in given):
            return f"its own {quantity}: positive is {says}"
    name = "contact.normal_speed"
    speeds = [t.given[name][0] for t in trials if name in t.given]
    if speeds and min(speeds) >= 0 and all(t.outcome in ("struck", "batted") for t in trials):
        return f"its own {name}: where it is not negative, ball and bat separate"
    if all(_beyond(t) and t.outcome != "beyond_bat" for t in trials):
        return "its own contact.position: beyond the ends of the bat"
    return ""


def _beyond(trial: Trial) -> bool:
    """Tell whether a contact that a trial gives is beyond the ends of the bat."""
    place = trial.given.get("contact.position")
    return place is not None and 2 * abs(place[1]) > trial.scene.bat.length


def _follows(trials: Trials) -> str:
    """Return from which of their own earlier values wrong outcomes follow, if most do; else ""."""
    both = {str(trials[0].outcome), str(trials[0].case.expected.outcome)}
    for quantity, outcomes, holds in (
        ("contact.margin", {"missed"}, lambda t, x: (t.outcome == "missed") is (x[0] <= 0)),
        ("contact.normal_speed", {"separating"},
         lambda t, x: (t.outcome == "separating") is (x[0] >= 0)),
        ("contact.position", {"beyond_bat"},
         lambda t, x: (t.outcome == "beyond_bat") is _beyond(t)),
        ("fence.clearance", {"home_run"}, lambda t, x: _leaves(t) is (t.outcome == "home_run")),
        ("fence.clearance", {"wall"}, lambda t, x: (t.outcome == "wall") is (x[0] <= 0)),
        ("impact.velocity", set(), _flies_so),
    ):  # fmt: skip
        if not outcomes <= both:
            continue
        given = [(t, t.given[quantity]) for t in trials if quantity in t.given]
        beside = [(t, x, t.expected.get(quantity, x)) for t, x in given]
        count = sum(holds(t, x) for t, x, true in beside
                    if math.dist(x, true) > FINE * max(math.hypot(*true), 1e-3))  # fmt: skip
        if count >= MOST * len(trials):
            where = "" if count == len(trials) else f"in {count} of them "
            return f"{where}this follows from its own {quantity}"
    return ""


def _flies_so(trial: Trial, velocity: Sequence[float]) -> bool:
    """Tell whether a ball that is struck so flies as it is told to."""
    scene, given = trial.scene, trial.given
    if not {"contact.position", "contact.time"} <= set(given) or "impact.spin" in given:
        return False
    said = {"position": given["contact.position"], "velocity": velocity}
    blocks = ("ball", "reading", "air", "gravity", "time_limit", "ground", "fence")
    whole = {name: x for name, x in scene.model_dump().items() if name in blocks}
    try:
        flight = FlightScene.model_validate({"id": scene.id, "launch": said, **whole})
        outcome = str(solve(flight, ANY_LAW, MODEL).outcome)
    except (ArithmeticError, ValueError):
        return False
    return trial.outcome == {"landed": "batted"}.get(outcome, outcome)


# --- besides numbers ------------------------------------------------------------------------------


def told_findings(trials: Trials, base: Change, known: Sequence[Finding]) -> Iterator[Finding]:
    """Yield what is told besides numbers, and is not so; and blocks that do not belong there."""
    struck = {f.stage for f in known}.isdisjoint(COLLISION)
    right = [t for t in trials if not t.confused]
    wrong: dict[str, list[tuple[Trial, object, object]]] = defaultdict(list)
    for t in right:
        facts = untrue(t.case.expected, t.told)
        made = told_by(_solved(t, base)) if facts and base is not NONE else {}
        for name, true, given in facts:
            # What follows from what is explained, or from another impact, is no other mistake.
            rightly = name not in OPTIONAL or (struck and _struck_rightly(t))
            if rightly and made.get(name) != given:
                wrong[name].append((t, true, given))
    for name, told in wrong.items():
        some = [t for t, _, _ in told]
        same = [t for t in right if name in t.told and t not in some]
        if name == "landing.fair" and (fair := _fair_otherwise(right)):
            # What is taken for fair tells the scenes.
            one = _told(stage_of(name), name, *fair, some, same)
            yield one.model_copy(update={"scenes": None})
            continue
        for names, sentence in _misled(name, [(true, given) for _, true, given in told]):
            yield _told(stage_of(name), name, names, sentence, some, same)
    beside: dict[str, list[Trial]] = defaultdict(list)
    for t in right:
        for name in superfluous(t.case.expected.outcome, t.expected, t.given):
            beside[name].append(t)
    for name, more in beside.items():
        outcomes = dict.fromkeys(str(t.case.expected.outcome) for t in more)
        same = [t for t in right if t not in more]
        what = name if "." in name else f"the block {name}"
        sentence = f"gives {what} with the outcome {' or '.join(outcomes)}"
        if others := sum(t.case.expected.outcome in outcomes for t in same):
            sentence += f" where the truth has none; in {others} other scenes with that outcome "
            sentence += "it belongs there"
        else:
            sentence += ", which has none"
        yield _told("outcome", name, [] if others else [f"{name}-given"], sentence, more, same)


def _struck_rightly(trial: Trial) -> bool:
    said, true = trial.given.get("impact.velocity"), trial.expected.get("impact.velocity")
    return not (said and true) or math.dist(said, true) <= NEAR * math.hypot(*true)


def _misled(name: str, told: Sequence[tuple[Any, Any]]) -> Iterator[tuple[list[str], str]]:
    """Yield what is told where something else is right, with a name if it is always the same."""
    whole = all(type(x) is int for pair in told for x in pair)
    shifts = {given - true for true, given in told} if whole else set()
    if len(shifts) == 1 and len(set(told)) > 1:
        (shift,) = shifts
        size = f"{abs(shift)} too {'large' if shift > 0 else 'small'}"
        yield [f"{name}{shift:+d}"], f"{name} is {size}, always"
        return
    for (true, given), count in Counter(told).most_common():
        what = "the truth has none" if true is None else f"{true} is right"
        yield [], f"{name} is told to be {given} where {what}, in {many(count, 'scene')}"


def _blocks(names: Iterable[str]) -> set[str]:
    return {name.partition(".")[0] for name in names}


def _told(
    stage: str, quantity: str, names: list[str], sentence: str, wrong: Trials,
    same: Trials
) -> Finding:  # fmt: skip
    return found(
        stage, sentence, len(wrong), len(wrong) + len(same), names, quantity=quantity,
        scenes=rule([t.case for t in wrong], [t.case for t in same]), example=wrong[0].case.id,
    )  # fmt: skip
