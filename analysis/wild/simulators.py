"""The simulators of the study: what they are, and how they are asked."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from analysis.writing import data


@dataclass(frozen=True)
class Method:
    """An integrator of a simulator."""

    name: str  # as the simulator has it
    usual: float  # the knob's value as the simulator comes, or as its examples have it
    word: str = ""  # by which the adapter knows it; empty if there is no choice
    order: int | None = None  # as its documentation or its name says; None: a controlled error
    steps: tuple[float, float, int] | None = None  # first and last value that is tried; how many
    second: float = 1.0  # how many steps of 1 s the knob's unit is

    @property
    def knobs(self) -> list[float]:
        """The knob's values that are tried."""
        return [] if self.steps is None else np.geomspace(*self.steps).tolist()


@dataclass(frozen=True)
class Simulator:
    """A simulator that installs from a package index."""

    title: str
    package: str  # on the index
    licence: str  # SPDX, where there is one
    purpose: str  # what it is made for
    adapted: str  # which inputs were put in the place of its own
    families: tuple[str, ...]  # of the golden data that it can take
    methods: tuple[Method, ...]  # that are tried
    # Numbers that it has built in: digits and order are looked at in scenes with these.
    constants: Mapping[str, float] = field(default_factory=dict)
    remark: str = ""  # what its source or its documentation says about what is seen here

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


SIMULATORS = tuple(
    Simulator(**one | {"methods": tuple(Method(**method) for method in one["methods"])})
    for one in data(__file__)["simulator"]
)
