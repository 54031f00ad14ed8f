"""Longball: the precision reference for a simulator of baseball at-bats."""

__version__ = "0.1.0"
