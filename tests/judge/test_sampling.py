"""Mistakes that are in the sampling, told from the drawn at-bats."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from longball.home_run import draw, paper_at_bats
from longball.judge.sampling import FEWEST, BadSamples, Sampling, judge_samples, read_samples
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene

Scene = dict[str, Any]


def at_bats(count: int = 1000, seed: int = 5, **switches: object) -> list[Scene]:
    """Return at-bats as a candidate writes them, impossible ones included."""
    samples = draw(paper_at_bats(SamplingReading.model_validate(switches)), count, seed)
    speed, aim, offset, tilt = (
        column.tolist() for column in (samples.speed, samples.aim, samples.offset, samples.tilt)
    )
    base = json.loads(AtBatScene(id="s").line())
    return [
        base
        | {"ball": dict(base["ball"]), "air": dict(base["air"])}
        | {"pitch": base["pitch"] | {"speed": speed[i], "aim": [aim[i], 1.8]}}
        | {"swing": base["swing"] | {"height_offset": offset[i], "tilt": tilt[i]}}
        for i in range(count)
    ]


def changed(block: str, key: str, change: Callable[[Any], Any], **switches: object) -> list[Scene]:
    drawn = at_bats(**switches)
    for scene in drawn:
        scene[block][key] = change(scene[block][key])
    return drawn


def named(sampling: Sampling) -> dict[str, list[str]]:
    return {found.quantity: found.named for found in sampling.wrong}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("count", [FEWEST, 5000])
def test_the_papers_at_bats_are_right(count: int, seed: int):
    found = judge_samples(at_bats(count, seed))
    assert found.at_bats == count
    assert len(found.drawn) == 4
    assert found.wrong == []
    assert all(d.right and d.fits for d in found.drawn)


@pytest.mark.parametrize(
    ("drawn", "mistakes"),
    [
        (at_bats(speed_spread="as_printed"), {"pitch.speed": ["missing-2"]}),
        (at_bats(offset_spread=0.0732), {"swing.height_offset": ["radius-or-diameter"]}),
        (changed("swing", "height_offset", lambda x: x / math.sqrt(2)),
         {"swing.height_offset": ["missing-2"]}),
        (changed("pitch", "speed", lambda v: 3.6 * v), {"pitch.speed": ["speed-in-km/h"]}),
        (changed("swing", "tilt", math.degrees), {"swing.tilt": ["tilt-in-degrees"]}),
        (changed("pitch", "aim", lambda a: [a[0] / 0.144, a[1]]),
         {"pitch.aim[0]": ["cells-for-metres"]}),
        (changed("pitch", "aim", lambda a: [a[0] + 3 * 0.144, a[1]]),
         {"pitch.aim[0]": ["cells-from-the-edge"]}),
        (changed("pitch", "aim", lambda a: [a[0] / 0.144 + 3, a[1]]),
         {"pitch.aim[0]": ["cells-from-the-edge"]}),
        (changed("pitch", "speed", lambda v: 3.6 * v, speed_spread="as_printed"),
         {"pitch.speed": ["missing-2", "speed-in-km/h"]}),
        (at_bats(speed_table="as_printed"), {"pitch.speed": ["table-columns"]}),
        (at_bats(speed_table="as_printed", speed_spread="as_printed"),
         {"pitch.speed": ["table-columns", "missing-2"]}),
        ([scene for scene in at_bats(2000, speed_table="as_printed")
          if scene["pitch"]["speed"] > 0], {"pitch.speed": ["table-columns"]}),
        (changed("ball", "radius", lambda r: 2 * r), {"ball.radius": ["radius-or-diameter"]}),
        (changed("air", "density", lambda _: 1.225), {"air.density": ["air-1.225"]}),
        ([scene | {"gravity": 9.81} for scene in at_bats()], {"gravity": ["g-9.81"]}),
        (changed("swing", "angular_speed", lambda _: 30.0), {"swing.angular_speed": []}),
    ],
)  # fmt: skip
@pytest.mark.sampled(every=3)
def test_a_mistake_is_named(drawn: list[Scene], mistakes: dict[str, list[str]]):
    assert named(judge_samples(drawn)) == mistakes


def test_left_for_right_shows_in_many_at_bats():
    # Both sides differ by 2 % of the pitches only: q = 0.52.
    drawn = at_bats(30_000)
    for scene in drawn:
        scene["pitch"]["aim"][0] *= -1
    assert named(judge_samples(drawn)) == {"pitch.aim[0]": ["left-for-right"]}


def test_the_width_of_a_cell_is_nobodys_mistake():
    found = judge_samples(at_bats(cell_width=0.2))
    assert found.wrong == []
    aim = next(d for d in found.drawn if d.quantity == "pitch.aim[0]")
    width = float(re.search("with cells ([0-9.]+) m wide", aim.sentence)[1])
    # The root of a mean square of 1,000 numbers with the kurtosis of these is known to 2 %.
    assert width == pytest.approx(0.2, rel=0.08)


def test_a_stranger_fits_nothing():
    noise = iter(np.random.default_rng(1).uniform(20, 50, 1000))
    (found,) = judge_samples(changed("pitch", "speed", lambda _: float(next(noise)))).wrong
    assert found.quantity == "pitch.speed"
    assert not found.fits
    assert found.named == []
    assert "none of the known" in found.sentence


def test_a_draw_counts_once_for_all_its_restitutions():
    drawn = at_bats(FEWEST)
    thrice = [scene | {"ball": {"restitution": e}} for scene in drawn for e in (0.41, 0.43, 0.45)]
    assert judge_samples(thrice).at_bats == FEWEST
    with pytest.raises(BadSamples, match=f"{FEWEST} are needed"):
        judge_samples(thrice[: 3 * FEWEST - 3])


def test_what_is_left_out_is_not_judged():
    speeds = [{"pitch": {"speed": scene["pitch"]["speed"]}} for scene in at_bats()]
    found = judge_samples(speeds)
    assert [d.quantity for d in found.drawn] == ["pitch.speed"]
    assert found.constants == []
    with pytest.raises(BadSamples, match="0 different at-bats"):
        judge_samples([{}] * 1000)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("{", "line 501: not JSON"),
        ("[1]", "line 501: not an at-bat"),
        ('{"kind": "flight"}', "line 501: not an at-bat"),
        (
            '{"pitch": {"speed": "fast"}}',
            "at-bat 501: pitch.speed is fast; must be a finite",
        ),
        ('{"pitch": {"speed": NaN}}', "at-bat 501: pitch.speed is nan"),
        ('{"pitch": {"speed": 1' + "0" * 400 + "}}", "at-bat 501: pitch.speed is 100"),
        ('{"pitch": 7}', "at-bat 501: pitch.speed: 7 has no speed"),
        ('{"pitch": {"aim": [true, 1.8]}}', r"at-bat 501: pitch.aim\[0\] is True"),
        ('{"pitch": {"aim": []}}', r"at-bat 501: pitch.aim\[0\]: \[\] has no \[0\]"),
        ("[" * 40_000, "line 501: not JSON"),
        ("x" * 70_000, "line 501: longer than"),
    ],
)
def test_a_line_that_is_no_at_bat_is_named(tmp_path: Path, line: str, why: str):
    path = tmp_path / "samples.jsonl"
    good = "\n".join(json.dumps(scene) for scene in at_bats(FEWEST))
    path.write_text(f"{good}\n{line}\n", encoding="utf-8")
    with pytest.raises(BadSamples, match=why):
        judge_samples(read_samples(path), path.name)


def test_one_random_number_behind_two_quantities_is_found():
    drawn = at_bats()
    order = sorted(range(len(drawn)), key=lambda i: drawn[i]["swing"]["tilt"])
    offsets = sorted(scene["swing"]["height_offset"] for scene in drawn)
    for i, offset in zip(order, offsets, strict=True):
        drawn[i]["swing"]["height_offset"] = offset
    (wrong,) = judge_samples(drawn).wrong
    assert wrong.named == ["dependence"]
    assert "swing.height_offset" in wrong.quantity
    assert "swing.tilt" in wrong.quantity


def test_a_quantity_that_hangs_on_its_last_draw_is_found():
    drawn = at_bats()
    for before, scene in zip(drawn[::2], drawn[1::2], strict=True):
        scene["swing"]["height_offset"] = -before["swing"]["height_offset"]
    assert ["dependence"] in [w.named for w in judge_samples(drawn).wrong]


def test_a_repeating_stream_ends_in_a_verdict():
    found = judge_samples(at_bats(40) * 50)
    assert [w.named for w in found.wrong] == [["repeating-stream"]]
    assert "40 different ones in 2000" in found.wrong[0].sentence
