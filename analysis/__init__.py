"""Longball's own studies: `python -m analysis [STUDY ...]` writes them into report/."""
