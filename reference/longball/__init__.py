"""Longball: the precision reference for baseball in flight.

>>> import longball as lb
>>> pitch = {"speed": 38.64, "aim": [-0.144, 1.8]}
>>> scene = lb.AtBat(pitch=pitch, swing={"height_offset": -0.03, "tilt": 0.14})
>>> result = lb.solve(scene)
>>> print(result.outcome, f"{result.landing.distance:.3f} m")
batted 101.406 m

SI units and radians throughout; omitted values are the paper's.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from longball import convergence, golden, judge
    from longball.api import AtBat, Flight, Impact, Pitch, home_run_probability, launch, solve
    from longball.engines.engine import CannotSolve
    from longball.model.air import Air, Weather
    from longball.model.numbers import Undecided
    from longball.model.readings import Reading
    from longball.model.scene import (
        Ball,
        Bat,
        Earth,
        Fence,
        Ground,
        Incoming,
        InvalidScene,
        Launch,
        Swing,
    )
    from longball.pitches import fit_pitches, measured
    from longball.questions.aiming import aim
    from longball.questions.inverse import fit
    from longball.questions.movement import (
        Movement,
        NineParameters,
        clock,
        movement,
        nine_parameters,
    )
    from longball.questions.parks import InPark, Park, in_parks, park, parks
    from longball.questions.spin import SpinFromMovement, spin_for, spin_from_movement
    from longball.questions.uncertainty import uncertainty
    from longball.solution import Path, Solution, State
    from longball.tables import solve_many

__version__ = "0.1.0"

# Where public names are, which are imported when they are first asked for.
_HOMES = {
    "api": (
        *("AtBat", "Flight", "Impact", "Pitch"),
        *("home_run_probability", "launch", "solve"),
    ),
    "engines.engine": ("CannotSolve",),
    "model.air": ("Air", "Weather"),
    "model.numbers": ("Undecided",),
    "model.readings": ("Reading",),
    "model.scene": (
        *("Ball", "Bat", "Earth", "Fence", "Ground", "Incoming", "InvalidScene", "Launch", "Swing"),
    ),
    "pitches": ("fit_pitches", "measured"),
    "questions.aiming": ("aim",),
    "questions.inverse": ("fit",),
    "questions.movement": ("Movement", "NineParameters", "clock", "movement", "nine_parameters"),
    "questions.parks": ("InPark", "Park", "in_parks", "park", "parks"),
    "questions.spin": ("SpinFromMovement", "spin_for", "spin_from_movement"),
    "questions.uncertainty": ("uncertainty",),
    "solution": ("Path", "Solution", "State"),
    "tables": ("solve_many",),
}
_PACKAGES = ("convergence", "golden", "judge")

__all__ = [
    "Air",
    "AtBat",
    "Ball",
    "Bat",
    "CannotSolve",
    "Earth",
    "Fence",
    "Flight",
    "Ground",
    "Impact",
    "InPark",
    "Incoming",
    "InvalidScene",
    "Launch",
    "Movement",
    "NineParameters",
    "Park",
    "Path",
    "Pitch",
    "Reading",
    "Solution",
    "SpinFromMovement",
    "State",
    "Swing",
    "Undecided",
    "Weather",
    "__version__",
    "aim",
    "clock",
    "convergence",
    "fit",
    "fit_pitches",
    "golden",
    "home_run_probability",
    "in_parks",
    "judge",
    "launch",
    "measured",
    "movement",
    "nine_parameters",
    "park",
    "parks",
    "solve",
    "solve_many",
    "spin_for",
    "spin_from_movement",
    "uncertainty",
]


def __getattr__(name: str) -> Any:
    # `import longball` alone loads no library.
    if name in _PACKAGES:
        return import_module(f"longball.{name}")
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"longball.{home}"), name)
    hint = ""
    if not name.startswith("_"):  # pickle, copy and others ask for names of that form
        from longball.model.names import did_you_mean

        hint = did_you_mean(name, __all__)
    raise AttributeError(f"module 'longball' has no attribute {name!r}{hint}")


def __dir__() -> list[str]:
    return __all__
