"""The simulators of the study: what they are, and how they are asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version

import numpy as np

AIR = ("flight-drag", "flight-both")  # families of the golden data, of those that take a lift
DRAG = ("flight-drag",)  # of those that take none
CALLBACK = "air, by a callback"


@dataclass(frozen=True)
class Method:
    """An integrator of a simulator.

    Attributes
    ----------
    name
        As the simulator has it.
    word
        By which the adapter knows it; empty if there is no choice.
    order
        As its documentation or its name says; None for an error that is controlled.
    usual
        The knob's value as the simulator comes, or as its examples have it.
    steps
        The first and the last value of the knob that are tried, and how many.
    second
        How many steps of 1 s the knob's unit is.
    """

    name: str
    word: str
    order: int | None
    usual: float
    steps: tuple[float, float, int] | None = None
    second: float = 1.0

    @property
    def knobs(self) -> list[float]:
        """The knob's values that are tried."""
        return [] if self.steps is None else np.geomspace(*self.steps).tolist()


@dataclass(frozen=True)
class Simulator:
    """A simulator that installs from a package index.

    Attributes
    ----------
    title
        Its name.
    package
        On the index.
    licence
        SPDX, where there is one.
    purpose
        What it is made for.
    adapted
        Which inputs were put in the place of its own.
    families
        Of the golden data that it can take.
    methods
        That are tried.
    constants
        Numbers that it has built in: digits and order are looked at in scenes with these.
    remark
        What its source or its documentation says about what is seen here.
    """

    title: str
    package: str
    licence: str
    purpose: str
    adapted: str
    families: tuple[str, ...]
    methods: tuple[Method, ...]
    constants: Mapping[str, float] = field(default_factory=dict)
    remark: str = ""

    @property
    def module(self) -> str:
        """The module of its adapter."""
        return f"analysis.wild.adapters.{self.package.lower().replace('-', '_')}"

    @property
    def version(self) -> str | None:
        """The version that is installed; None if it is not."""
        try:
            return version(self.package)
        except PackageNotFoundError:
            return None


USUAL_STEPS = (0.05, 0.0025, 7)

SIMULATORS = (
    Simulator(
        "MuJoCo",
        "mujoco",
        "Apache-2.0",
        "robots and contact",
        "lift, by a callback; drag is its own, of an ellipsoid",
        AIR,
        (
            Method("Euler", "Euler", 1, 0.002, USUAL_STEPS),
            Method("RK4", "RK4", 4, 0.002, (0.1, 0.005, 7)),
        ),
        remark=(
            "the drag of its ellipsoids is ρ c A V² for a sphere, without the half: its "
            "coefficient is C_D/2. A sphere that does not spin has no lift there."
        ),
    ),
    Simulator(
        "PyBullet",
        "pybullet",
        "Zlib",
        "robots and games",
        CALLBACK.replace("by a callback", "as a force before each step"),
        AIR,
        (Method("semi-implicit Euler", "", 1, 1 / 240, USUAL_STEPS),),
    ),
    Simulator(
        "Pymunk",
        "pymunk",
        "MIT",
        "games in two dimensions",
        CALLBACK,
        AIR,
        (Method("Euler", "", 1, 0.01, USUAL_STEPS),),
    ),
    Simulator(
        "REBOUND",
        "rebound",
        "GPL-3.0-only",
        "planets",
        "weight and " + CALLBACK,
        AIR,
        (
            Method("leapfrog", "leapfrog", 2, 0.01, USUAL_STEPS),
            Method("IAS15", "ias15", None, 0.01),
        ),
        remark=(
            "its leapfrog is made for forces that do not depend on the velocity. IAS15 "
            "chooses its own steps; its points were asked for every 0.01 s."
        ),
    ),
    Simulator(
        "Exudyn",
        "exudyn",
        "BSD-like, its own",
        "flexible multibody systems",
        "weight and " + CALLBACK,
        AIR,
        (
            Method("explicit midpoint", "ExplicitMidpoint", 2, 0.01, USUAL_STEPS),
            Method("RK33", "RK33", 3, 0.01, USUAL_STEPS),
            Method("RK44", "RK44", 4, 0.01, (0.1, 0.005, 7)),
            Method("RK67", "RK67", 6, 0.01, (0.2, 0.02, 7)),
        ),
    ),
    Simulator(
        "pitchphys",
        "pitchphys",
        "MIT",
        "pitches, for teaching",
        "its constant coefficients in place of those that depend on spin",
        ("pitch",),
        (
            Method("RK45", "RK45", None, 1e-8),
            Method("DOP853", "DOP853", None, 1e-12),
        ),
        remark=(
            "its frame is said to be right-handed, with x to the catcher's right, y to the "
            "plate and z up, which no frame can be; its cross products are right-handed."
        ),
    ),
    Simulator(
        "py-ballisticcalc",
        "py-ballisticcalc",
        "LGPL-3.0",
        "small arms",
        "one C_D at every Mach number; one density at every height",
        DRAG,
        (
            Method("Euler", "python+euler", 1, 1.0, (8.0, 0.5, 7), 0.5 / 100),
            Method("velocity Verlet", "python+verlet", 2, 1.0, (32.0, 2.0, 7), 0.001),
            Method("RK4", "python+rk4", 4, 1.0, (64.0, 4.0, 7), 0.0025),
        ),
        remark=(
            "a constant in its drag is written with six digits, which makes the drag too weak by "
            "eight parts in ten million. Its Euler shortens the step as the speed grows."
        ),
    ),
    Simulator(
        "ballistics-engine",
        "ballistics-engine",
        "MIT OR Apache-2.0",
        "small arms",
        "one C_D at every Mach number; a pressure for the density",
        ("flight-drag",),
        (
            Method("Euler", "euler", 1, 0.001, USUAL_STEPS),
            Method("RK4", "rk4", 4, 0.001, USUAL_STEPS),
            Method("RK45", "rk45", None, 0.001),
        ),
        {"gravity": 9.80665},
        remark=(
            "gravity is 9.80665 m/s², and the density falls with height, as over a range of "
            "kilometres it must."
        ),
    ),
    Simulator(
        "ProjectilePy",
        "ProjectilePy",
        "MIT",
        "teaching, in two dimensions",
        "a table of densities that are all the same",
        DRAG,
        (Method("Euler", "", 1, 0.0005, USUAL_STEPS),),
        remark=(
            "it ends at the first step that is below the ground and answers with that step. "
            "The gravity that it comes with is 9.981 m/s²."
        ),
    ),
    Simulator(
        "freefall",
        "freefall",
        "MIT",
        "balls of a robot contest",
        "the height at which it stops",
        DRAG,
        (Method("leapfrog", "", 2, 0.001, USUAL_STEPS),),
        remark=(
            "its drag acts on the horizontal and on the vertical speed, each for itself, "
            "which is not the square of the speed along the path."
        ),
    ),
)
