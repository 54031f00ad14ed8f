"""Flights in ball arithmetic, with a proof in every step."""

from longball.engines.enclosure.balls import Balls
from longball.engines.enclosure.engine import Enclosure

__all__ = ["Balls", "Enclosure"]
