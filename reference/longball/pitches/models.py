"""Models of flight by name: drag, lift, ball and air from one source each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from longball.model.arrays import Array
from longball.model.names import one_of
from longball.model.scene import Ball
from longball.pitches.statcast import RPM, MeasuredFlies, MeasuredPitches

Coefficient = float | Mapping[str, Any]

STANDARD_GRAVITY = 9.80665  # m/s²


@dataclass(frozen=True)
class FlightModel:
    """The forces on a measured ball."""

    source: str  # author, and the data of the fit
    # ``drag_coefficient`` and ``lift_coefficient`` of a scene; without air, both are None.
    drag: Coefficient | None
    lift: Coefficient | None
    density: float | None = None  # kg/m³; by default that of the game's weather
    spin: bool = True  # True if lift depends on the spin; otherwise it is upwards, as in the paper
    # Mass and radius that differ from the paper's.
    ball: Mapping[str, float] = field(default_factory=dict)
    gravity: float = STANDARD_GRAVITY  # m/s²
    side: Mapping[str, Any] | None = None  # ``side_coefficient`` of a scene

    def blocks(self, temperature: float, elevation: float) -> dict[str, Any]:
        """Return the blocks of a scene in the weather of a game, K and m."""
        air: dict[str, Any] | None = None
        if self.drag is not None:
            density: Any = self.density
            # Statcast has neither pressure nor humidity: standard pressure, and half of saturation.
            if density is None:
                density = {
                    "temperature": temperature,
                    "pressure": 101325.0,
                    "humidity": 0.5,
                    "elevation": elevation,
                }
            air = {"density": density, "drag_coefficient": self.drag, "lift_coefficient": self.lift}
            if self.side is not None:
                air["side_coefficient"] = self.side
        return {"air": air, "gravity": self.gravity, "ball": dict(self.ball)}


def _of_unit_length(per_metre: float, density: float) -> float:
    """Return the coefficient C for which ρ A C / (2 m) has a given value, 1/m; paper's ball."""
    ball = Ball()
    return 2.0 * ball.mass * per_metre / (density * math.pi * ball.radius**2)


# kg/m³. Giordano gives the products ρ A C / (2 m), which do not change with this choice.
_SEA_LEVEL_DENSITY = 1.2
_NATHAN_LIFT = {"law": "rational", "numerator": 1.12, "constant": 0.583, "slope": 2.333}
# 5.125 oz, and a circumference of 9.125 in: the middle of the range in the rules of baseball.
_RULE_BALL = {"mass": 5.125 * 0.028349523125, "radius": 9.125 * 0.0254 / (2.0 * math.pi)}

Model = Literal["vacuum", "paper", "constants", "giordano", "nathan", "crisis"]

MODELS: dict[Model, FlightModel] = {
    "vacuum": FlightModel("no air", None, None, spin=False),
    "paper": FlightModel(
        "Kuninaka, Kosaka and Mizutani, Sec. III.B: C_D 0.4, C_L 0.2 upwards, 1.29 kg/m³",
        0.4, 0.2, 1.29, spin=False, gravity=9.8,
    ),
    "constants": FlightModel(
        "constant C_D 0.390 and C_L 0.089: the best for the flies of the day that longball ships",
        0.390, 0.089, spin=False,
    ),
    "giordano": FlightModel(
        "N. J. Giordano and H. Nakanishi, Computational Physics (2nd ed. 2006), Sec. 2.3: drag "
        "0.0039 + 0.0058/(1 + exp((v - 35)/5)) 1/m, Magnus force 4.1e-4 ω × v",
        {
            "law": "crisis",
            "high_speed": _of_unit_length(0.0039, _SEA_LEVEL_DENSITY),
            "low_speed": _of_unit_length(0.0039 + 0.0058, _SEA_LEVEL_DENSITY),
            "speed": 35.0,
            "width": 5.0,
        },
        {"law": "linear", "slope": _of_unit_length(4.1e-4, _SEA_LEVEL_DENSITY) / Ball().radius},
        _SEA_LEVEL_DENSITY,
    ),
    "nathan": FlightModel(
        "A. M. Nathan, Trajectory Calculator (2016; fitted to the batted balls of 2015), as in "
        "pybaseball and gist.github.com/bdilday/8ed04a935b26a1a0291c82d9b3fd01e0",
        {"law": "spin", "constant": 0.3008, "per_spin": 0.0292 / (1000.0 * RPM)},
        _NATHAN_LIFT, ball=_RULE_BALL,
    ),
    "crisis": FlightModel(
        "a drag crisis fitted to the pitches and flies of the day that longball ships, with "
        "Nathan's lift",
        {
            "law": "crisis", "high_speed": 0.33, "low_speed": 0.50, "speed": 31.4, "width": 3.0,
            "per_spin": 0.0078 / (1000.0 * RPM),
        },
        _NATHAN_LIFT,
    ),
}  # fmt: skip


def model_of(name: str) -> FlightModel:
    """Return a model of flight by its name; a ValueError gives similar names."""
    if name not in MODELS:
        raise ValueError(f"model {name}: there is none{one_of('the models are', name, MODELS)}")
    return MODELS[name]


def regression_spin(flies: MeasuredFlies, side_spin: bool = True) -> Array:
    """Return the spin of batted balls by a published regression, rad/s, shape (n, 3).

    In rpm and degrees, with s = 1 for a right-handed batter and -1 for a left-handed one, and the
    direction φ of the launch positive to right field, backspin is -763 + 120 θ + 21 φ s, and side
    spin -849 s - 94 φ. The bearing of the landing replaces φ, because tables lack it.
    """
    # Coefficients as in the source of the model "nathan".
    theta, phi = np.degrees(flies.angle), np.degrees(flies.bearing)
    backspin = -763.0 + 120.0 * theta + 21.0 * phi * flies.side
    side = -849.0 * flies.side - 94.0 * phi if side_spin else np.zeros_like(phi)
    return flies.spin(backspin * RPM, side * RPM)


# Fraction of a pitch's spin that is perpendicular to its velocity at the release, by Statcast's
# type. Fitted with the model "nathan" to all games of the shipped day (`python -m analysis
# reality`, which also fits them to half of the games and predicts the others).
ACTIVE_SHARE = {
    "CH": 0.745, "CU": 0.491, "FA": 0.752, "FC": 0.176, "FF": 0.763, "FO": 0.488, "FS": 0.686,
    "KC": 0.451, "SI": 0.751, "SL": 0.134, "ST": 0.391,
}  # fmt: skip


def expected_spin(measured: MeasuredPitches | MeasuredFlies) -> Array:
    """Return the spin of measured balls, rad/s, shape (n, 3).

    Batted balls have `regression_spin`. Pitches have their measured rate and axis, and the active
    share of their type in `ACTIVE_SHARE`, or the mean of all types.
    """
    if isinstance(measured, MeasuredFlies):
        return regression_spin(measured)
    usual = float(np.mean(list(ACTIVE_SHARE.values())))
    return measured.spin(np.array([ACTIVE_SHARE.get(kind, usual) for kind in measured.labels]))
