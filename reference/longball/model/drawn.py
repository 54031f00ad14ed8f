"""An at-bat together with how it was drawn.

The two readings that say so stand side by side in one ``reading`` block, as the golden data have
them; the scene that is solved has its own alone.
"""

from __future__ import annotations

from longball.model.readings import Reading, SamplingReading, readings_of
from longball.model.scene import AtBatScene


class DrawnReading(Reading, SamplingReading):
    """The reading of a scene, and that of the sampling that it is drawn by."""


class DrawnAtBat(AtBatScene):
    """An at-bat whose ``reading`` has the switches of the sampling that it is drawn by, too."""

    reading: DrawnReading = DrawnReading()

    @classmethod
    def of(cls, scene: AtBatScene, sampling: SamplingReading) -> DrawnAtBat:
        """Return an at-bat with the sampling that it is drawn by."""
        switches = scene.reading.model_dump() | sampling.model_dump()
        return cls(**dict(scene) | {"reading": DrawnReading(**switches)})

    @property
    def scene(self) -> AtBatScene:
        """The at-bat that is solved."""
        reading, _ = readings_of(self.reading.model_dump())
        return AtBatScene(**dict(self) | {"reading": reading})

    @property
    def sampling(self) -> SamplingReading:
        """What it is drawn by."""
        _, sampling = readings_of(self.reading.model_dump())
        return sampling
