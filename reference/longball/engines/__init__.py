"""How numbers are made: each engine solves a scene into a result."""
