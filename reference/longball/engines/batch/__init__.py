"""Many scenes at once, compiled: the at-bat as one array call."""

from longball.engines.batch.engine import Batch

__all__ = ["Batch"]
