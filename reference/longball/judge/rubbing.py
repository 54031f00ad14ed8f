"""Known mistakes in the oblique impulse: where ball and bat rub.

Each is the impulse of `longball.model.impact`, put together otherwise: another slip, another K, a
ball that grips or slides where it should not, or slides with another impulse.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from longball.engines.chain import collide
from longball.engines.chain.collision import ContactState, Impact
from longball.judge.changes import Mistake
from longball.judge.stages import Change, with_values
from longball.model import impact
from longball.model.bat import (
    bat_rotation,
    collision_parameters,
    inertia_factor,
    inverse_mass_arguments,
    tangential_restitution,
)
from longball.model.numbers import DOUBLES, Vector

Floats = Vector[float]
Matrix = tuple[float, ...]

STILL = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Parts:
    """What the impulse is put together from; a mistake has another part."""

    # Of ball and bat as they go into the slip, rad/s: from the contact and the scene.
    spin: Callable[[ContactState[float]], Floats] = lambda contact: contact.spin or STILL
    rotation: Callable[[Any], Floats] = lambda scene: bat_rotation(scene.swing, DOUBLES)
    # Their tangential restitution, from the scene's and ẽ.
    tangential: Callable[[float, float], float] = lambda given, e: given
    # Of ball and bat as they go into the slip, m, from the scene.
    radii: Callable[[Any], tuple[float, float]] = lambda s: (s.ball.radius, s.bat.radius)
    # Those of `inverse_mass` that are others, from the scene and the right ones.
    arguments: Callable[[Any, Mapping[str, float]], Mapping[str, float]] = lambda scene, given: {}
    # K, 1/kg, from what it is and from its own K_nn, which 1/μ stands for.
    matrix: Callable[[Matrix, float], Matrix] = lambda k, own: k
    # Whether the ball grips, from whether it should.
    grips: Callable[[bool], bool] = lambda grips: grips
    # The impulse of a ball that slides, N s: from the right one, the gripping one, and the
    # frictionless one along the normal.
    sliding: Callable[[Floats, Floats, float], Floats] = lambda slid, gripped, plain: slid


def rubbed(**parts: Any) -> Change:
    """Return the change of some of the `Parts`."""
    made = Parts(**parts)

    def collision(cases: Any, contact: Any, error: Any, *carried: Any) -> tuple[Any, ...]:
        if cases.scene.bat.friction is None:
            return collide(cases, contact, error, *carried)
        return cases, _struck(cases.scene, contact, made), *carried

    return Change(model=lambda model: replace(model, collide=collision))


def _struck(scene: Any, contact: ContactState[float], parts: Parts) -> Impact[float]:
    """Return the impulse with such parts, and what it does."""
    ball, bat, normal = scene.ball, scene.bat, contact.normal
    pair = collision_parameters(ball, bat, contact.lever_arm, scene.reading, DOUBLES)
    e = pair.restitution
    e_t = parts.tangential(tangential_restitution(bat, DOUBLES), e)
    motion = contact.velocity, parts.spin(contact), contact.bat_velocity, parts.rotation(scene)
    g = contact.normal_speed, *impact.slip(*motion, normal, *parts.radii(scene))[1:]
    given = inverse_mass_arguments(ball, bat, contact.lever_arm, scene.reading, DOUBLES)
    own, *others = impact.inverse_mass(**{**given, **parts.arguments(scene, given)})
    k = parts.matrix((1 / pair.reduced_mass, *others), own)

    wanted = impact.gripping_impulse(k, e, e_t, g)
    rubbed = math.hypot(*wanted[1:])
    margin = bat.friction * wanted[0] - rubbed
    grips = parts.grips(margin > 0)
    push = wanted
    if not grips:
        initial = scene.reading.slide_direction == "initial"
        way = g[1:] if initial else (-wanted[1], -wanted[2])
        speed = math.hypot(*way) or 1.0  # without slip there is no direction, and no friction
        direction = way[0] / speed, way[1] / speed
        resistance = impact.sliding_resistance(k, bat.friction, direction)
        slid = impact.sliding_impulse(resistance, e, bat.friction, g, direction)
        push = parts.sliding(slid, wanted, impact.impulse(pair.reduced_mass, e, g[0]))
    factor = inertia_factor(ball, DOUBLES)
    return Impact(
        e,
        push[0],
        impact.velocity_after_push(contact.velocity, push, normal, ball.mass),
        impact.push_energy(push, g, k),
        impact.spin_after_push(contact.spin or STILL, push, normal, ball.mass, ball.radius, factor),
        "grip" if grips else "slide",
        margin / (bat.friction * abs(wanted[0])),
    )


def _along(factor: Callable[[Floats, Floats, float], float]) -> Callable[..., Floats]:
    """Return a sliding impulse with another normal part, and friction in proportion."""

    def sliding(slid: Floats, gripped: Floats, plain: float) -> Floats:
        share = factor(slid, gripped, plain) / slid[0]
        return share * slid[0], share * slid[1], share * slid[2]

    return sliding


def _leaning(factor: float, scene: Any) -> Floats:
    """Return the bat's rotation with a factor of the tilt."""
    tilt = factor * scene.swing.tilt
    return bat_rotation(with_values(scene, {"swing.tilt": tilt}).swing, DOUBLES)


def _reversed(vector: Floats) -> Floats:
    x, y, z = vector
    return -x, -y, -z


def _squared(scene: Any) -> Any:
    friction = getattr(getattr(scene, "bat", None), "friction", None)
    return scene if friction is None else with_values(scene, {"bat.friction": friction**2})


_SLIP = "g = V + ω × (-R n) - V_b - Ω_b × (r_b n), with the bat's Ω_b = ω'(-sin θ, 0, cos θ)"
_K = "g' = g + K P, with K of ball and bat at the point of contact, and n·K n = 1/μ"
_CONE = (
    "the ball grips if the gripping impulse lies within the cone |P_t| ≤ μ_f P_n, else it slides"
)
_SLID = "P = -(1 + ẽ) g_n/(n·K(n - μ_f t)) (n - μ_f t)"

RUBBING: tuple[Mistake, ...] = (
    Mistake("friction-spin-sign", "counts the ball's spin the other way round in the slip", _SLIP,
            rubbed(spin=lambda contact: _reversed(contact.spin or STILL))),
    Mistake("friction-rotation-level", "turns the bat's surface about z, whatever the tilt", _SLIP,
            rubbed(rotation=partial(_leaning, 0.0))),
    Mistake("friction-rotation-tilt", "tilts the bat's axis of rotation the wrong way", _SLIP,
            rubbed(rotation=partial(_leaning, -1.0))),
    Mistake("friction-rotation-sign", "counts the bat's rotation the other way round in the slip",
            _SLIP, rubbed(rotation=lambda s: _reversed(bat_rotation(s.swing, DOUBLES)))),
    Mistake("friction-bat-radius", "takes the bat's radius for the ball's in the slip", _SLIP,
            rubbed(radii=lambda s: (s.bat.radius, s.bat.radius))),
    Mistake("friction-ball-radius", "takes the ball's radius for the bat's in the slip", _SLIP,
            rubbed(radii=lambda s: (s.ball.radius, s.ball.radius))),
    Mistake("friction-uncoupled", "leaves out of K what couples the normal to the slip along the "
            "bat", _K, rubbed(matrix=lambda k, own: (k[0], 0.0, *k[2:]))),
    Mistake("friction-bat-fixed", "leaves the bat out of K, as if it gave way along the normal "
            "only", _K, rubbed(arguments=lambda s, given: {
                "inverse_bat_mass": 0.0, "inertia": math.inf, "axial_inertia": math.inf})),
    Mistake("friction-own-normal", "has n·K n of the bat itself in place of 1/μ", _K,
            rubbed(matrix=lambda k, own: (own, *k[1:]))),
    Mistake("friction-at-centre", "has K at the ball's centre, not at the point of contact", _K,
            rubbed(arguments=lambda s, given: {"bat_radius": s.ball.radius + s.bat.radius})),
    Mistake("friction-on-axis", "has K on the bat's axis, not at the point of contact", _K,
            rubbed(arguments=lambda s, given: {"bat_radius": 0.0})),
    Mistake("friction-same-inertia", "takes the bat's moment of inertia across its axis for that "
            "about it", _K, rubbed(arguments=lambda s, given: {
                "axial_inertia": given["inertia"]})),
    Mistake("friction-ball-as-ring", "has m R² for the ball's moment of inertia in K", _K,
            rubbed(arguments=lambda s, given: {"inertia_factor": 1.0})),
    Mistake("friction-bat-pivoted", "leaves 1/M of a free bat out of K", _K,
            rubbed(arguments=lambda s, given: {"inverse_bat_mass": 0.0})),
    *(Mistake(f"friction-{name}-axial", f"{words} for the bat's moment of inertia about its axis, "
              "M r_b²/2", _K, rubbed(arguments=lambda s, given, factor=factor: {
                  "axial_inertia": factor * given["axial_inertia"]}))
      for name, words, factor in (("half", "takes M r_b²/4", 0.5), ("double", "takes M r_b²", 2.0),
                                  ("infinite", "takes infinity", math.inf))),
    Mistake("one-restitution", "takes ẽ for the tangential restitution",
            "bat.tangential_restitution, or 0.3", rubbed(tangential=lambda given, e: e)),
    Mistake("always-grips", "lets the ball grip always", _CONE, rubbed(grips=lambda grips: True)),
    Mistake("always-slides", "lets the ball slide always", _CONE,
            rubbed(grips=lambda grips: False)),
    Mistake("slides-with-gripping-impulse", "slides with the normal part of the gripping impulse",
            _SLID, rubbed(sliding=_along(lambda slid, gripped, plain: gripped[0]))),
    Mistake("slides-with-plain-impulse", "slides with the normal impulse of a bat without "
            "friction, -μ(1 + ẽ) g_n", _SLID,
            rubbed(sliding=_along(lambda slid, gripped, plain: plain))),
    Mistake("slides-forward", "lets the friction act along the slip, not against it", _SLID,
            rubbed(sliding=lambda slid, *others: (slid[0], -slid[1], -slid[2]))),
    Mistake("friction-squared", "squares bat.friction", _CONE, Change(_squared)),
)  # fmt: skip
