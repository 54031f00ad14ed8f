"""The surroundings of a ball in flight: density of the air, speed of sound, wind, rotating Earth.

Heights are those of the scene's z, above the plane z = 0. Sources: density, Nathan's trajectory
calculator as coryfront.in and pybaseball have it; vapour pressure, A. L. Buck, J. Appl. Meteorol.
20 (1981) 1527, revised 1996. Constants are the doubles nearest to what is printed here.
"""

from __future__ import annotations

from typing import Any

from longball.model import trace
from longball.model.numbers import N, Numbers, Vector, present, scaled
from longball.model.trace import ZERO

# --- density --------------------------------------------------------------------------------------

ZERO_CELSIUS = 273.15  # K
STANDARD_PRESSURE = 101325.0  # Pa
DRY_DENSITY = 1.2929  # kg/m³, at these two
LIGHTER = 0.3783  # of a vapour's density, by which it is less than that of dry air


def density(scene: Any, numbers: Numbers) -> N:
    """Return the density of the air at height 0, kg/m³.

    A number of the scene; or by the weather, with the temperature T, the pressure p at sea level,
    the humidity φ and the elevation h,

        ``ρ = 1.2929 (273.15/T) (p e^(-βh) - 0.3783 φ p_s) / 101325``,  β = 1.217e-4 /m,
        ``p_s = 611.16 Pa exp((18.687 - t/234.5) t / (257.14 + t))``,  t = T - 273.15 (°C).

    If the reading says that p is the pressure at the station, h does not matter.
    """
    given = scene.air.density
    if not hasattr(given, "temperature"):
        return numbers.exact(given)
    exact, exp = numbers.exact, numbers.functions["exp"]
    temperature, pressure = exact(given.temperature), exact(given.pressure)
    if scene.reading.pressure != "station":
        pressure = pressure * exp(-(exact(1.217e-4) * exact(given.elevation)))
    # °C, the argument of Buck's formula.
    t = temperature - exact(ZERO_CELSIUS)
    exponent = (exact(18.687) - t / exact(234.5)) * t / (exact(257.14) + t)
    # Partial pressure of the vapour, Pa.
    vapour = exact(given.humidity) * exact(611.16) * exp(exponent)
    dry = exact(DRY_DENSITY) * (exact(ZERO_CELSIUS) / temperature)
    # Vapour replaces air of the same pressure and weighs 0.6217 of it.
    return dry * (pressure - exact(LIGHTER) * vapour) / exact(STANDARD_PRESSURE)


def speed_of_sound(scene: Any, numbers: Numbers) -> N:
    """Return the speed of sound, m/s: ``331.3 √(T/273.15)``."""
    temperature = numbers.exact(scene.air.density.temperature)
    return numbers.exact(331.3) * numbers.sqrt(temperature / numbers.exact(ZERO_CELSIUS))


# --- the wind -------------------------------------------------------------------------------------

ROUGHNESS = "roughness"  # z_0, m, as a strength of the law: the profile ends at z = -z_0


def wind(p: Any, height: Any) -> Vector:
    """Return the wind, m/s: the same everywhere, or ``W_h ln((z + z_0)/z_0) / ln((h + z_0)/z_0)``.

    Of a profile, the strengths are ``W_h / ln((h + z_0)/z_0)``.
    """
    velocity = p.wind_s, p.wind_y, p.wind_z
    if p.roughness is ZERO:
        return velocity
    return scaled(p.auxiliary_for(trace.log(1.0 + height / p.roughness)), velocity)


def wind_strengths(
    scene: Any, frame: Any, numbers: Numbers
) -> tuple[tuple[dict[str, N], ...], tuple[N, ...]]:
    """Return the winds from the ground up, and the heights above which the next one blows."""
    given = scene.air.wind
    velocity = frame.components(getattr(given, "velocity", given), numbers)
    profile: dict[str, N] = {}
    if hasattr(given, ROUGHNESS):
        height, roughness = numbers.exact(given.height), numbers.exact(given.roughness)
        # Divided once here: the law multiplies by the logarithm of the present height.
        rise = numbers.functions["log"]((height + roughness) / roughness)
        velocity = velocity[0] / rise, velocity[1] / rise, velocity[2]
        profile = {ROUGHNESS: roughness}
    wind = present({"wind_s": velocity[0], "wind_y": velocity[1], "wind_z": velocity[2]}, numbers)
    # Without a wind there is nothing to profile.
    wind = wind and wind | profile
    if hasattr(given, "above") and wind:
        # Still air below the height, the wind above it: a switch of the law.
        return ({}, wind), (numbers.exact(given.above),)
    return (wind,), ()


# --- the Earth ------------------------------------------------------------------------------------

ROTATION = 7.292115e-5  # rad/s


def earth_strengths(scene: Any, frame: Any, numbers: Numbers) -> dict[str, N]:
    """Return the components of ``Ω (cos λ north + sin λ up)`` in the frame of a flight.

    λ is the latitude. The scene's +x has an azimuth, from north to the east, and +y is to its left.
    """
    if scene.earth is None:
        return {}
    rotation = numbers.exact(ROTATION)
    level, up = numbers.cos_sin(numbers.exact(scene.earth.latitude))
    # North as x and y: +x is at the azimuth α from it, so that north is at α to the left of +x.
    north_x, north_y = numbers.cos_sin(numbers.exact(scene.earth.azimuth))
    # Ω cos λ, which points to the north.
    level = rotation * level
    s, y, z = frame.turned((level * north_x, level * north_y, rotation * up))
    return present({"earth_s": s, "earth_y": y, "earth_z": z}, numbers)
