"""The model: scenes, laws and formulas, before any number is computed."""
