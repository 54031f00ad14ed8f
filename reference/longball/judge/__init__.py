"""Holding another implementation against the truth."""
