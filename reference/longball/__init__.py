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
    from longball import convergence as convergence
    from longball import golden as golden
    from longball import judge as judge
    from longball.api import AtBat as AtBat
    from longball.api import Flight as Flight
    from longball.api import Impact as Impact
    from longball.api import Pitch as Pitch
    from longball.api import home_run_probability as home_run_probability
    from longball.api import launch as launch
    from longball.api import solve as solve
    from longball.engines.engine import CannotSolve as CannotSolve
    from longball.model.air import Air as Air
    from longball.model.air import Weather as Weather
    from longball.model.numbers import Undecided as Undecided
    from longball.model.readings import Reading as Reading
    from longball.model.scene import Ball as Ball
    from longball.model.scene import Bat as Bat
    from longball.model.scene import Earth as Earth
    from longball.model.scene import Fence as Fence
    from longball.model.scene import Ground as Ground
    from longball.model.scene import Incoming as Incoming
    from longball.model.scene import InvalidScene as InvalidScene
    from longball.model.scene import Launch as Launch
    from longball.model.scene import Swing as Swing
    from longball.pitches import fit_pitches as fit_pitches
    from longball.pitches import measured as measured
    from longball.questions.aiming import aim as aim
    from longball.questions.inverse import fit as fit
    from longball.questions.movement import Movement as Movement
    from longball.questions.movement import NineParameters as NineParameters
    from longball.questions.movement import clock as clock
    from longball.questions.movement import movement as movement
    from longball.questions.movement import nine_parameters as nine_parameters
    from longball.questions.parks import InPark as InPark
    from longball.questions.parks import Park as Park
    from longball.questions.parks import in_parks as in_parks
    from longball.questions.parks import park as park
    from longball.questions.parks import parks as parks
    from longball.questions.spin import SpinFromMovement as SpinFromMovement
    from longball.questions.spin import spin_for as spin_for
    from longball.questions.spin import spin_from_movement as spin_from_movement
    from longball.questions.uncertainty import uncertainty as uncertainty
    from longball.solution import Path as Path
    from longball.solution import Solution as Solution
    from longball.solution import State as State
    from longball.tables import solve_many as solve_many

__version__ = "0.1.0"

# Where public names are, which are imported when they are first asked for.
_HOMES = {
    "api": "AtBat Flight Impact Pitch home_run_probability launch solve",
    "engines.engine": "CannotSolve",
    "model.air": "Air Weather",
    "model.numbers": "Undecided",
    "model.readings": "Reading",
    "model.scene": "Ball Bat Earth Fence Ground Incoming InvalidScene Launch Swing",
    "pitches": "fit_pitches measured",
    "questions.aiming": "aim",
    "questions.inverse": "fit",
    "questions.movement": "Movement NineParameters clock movement nine_parameters",
    "questions.parks": "InPark Park in_parks park parks",
    "questions.spin": "SpinFromMovement spin_for spin_from_movement",
    "questions.uncertainty": "uncertainty",
    "solution": "Path Solution State",
    "tables": "solve_many",
}
_PACKAGES = ("convergence", "golden", "judge")

__all__ = sorted([*" ".join(_HOMES.values()).split(), *_PACKAGES, "__version__"])


def __getattr__(name: str) -> Any:
    # `import longball` alone loads no library.
    if name in _PACKAGES:
        return import_module(f"longball.{name}")
    for home, names in _HOMES.items():
        if name in names.split():
            return getattr(import_module(f"longball.{home}"), name)
    hint = ""
    if not name.startswith("_"):  # pickle, copy and others ask for names of that form
        from longball.model.names import did_you_mean

        hint = did_you_mean(name, __all__)
    raise AttributeError(f"module 'longball' has no attribute {name!r}{hint}")


def __dir__() -> list[str]:
    return __all__
