"""The chain of an at-bat: pitch, plate, contact, impact, landing.

Written once, over any engine, any number system, and one scene or columns of scenes (`run`). It
follows the paper's Sec. III: the throw, the swing that is aimed at where the throw would cross the
plate (`at_bat`), the collision of Sec. III.C and Appendix A (`collision`), the flight (`flying`) to
the ground or the fence (`landing`). Its parts, the forces and the collision, are handed in: a known
mistake is the same chain with another part. `single` makes results of scenes, one by one.
"""

from longball.engines.chain.at_bat import CHAINS, finish, meet_bat
from longball.engines.chain.collision import MODEL, Model, collide
from longball.engines.chain.flying import fly
from longball.engines.chain.landing import land
from longball.engines.chain.run import Run
from longball.engines.chain.single import (
    BLOCKS,
    DISCRETE,
    PARTS,
    approach_of,
    quantities_of,
    solve,
    solve_each,
    solve_once,
    solve_with_path,
    solve_with_points,
    solve_with_restitutions,
)

__all__ = [
    "BLOCKS",
    "CHAINS",
    "DISCRETE",
    "MODEL",
    "PARTS",
    "Model",
    "Run",
    "approach_of",
    "collide",
    "finish",
    "fly",
    "land",
    "meet_bat",
    "quantities_of",
    "solve",
    "solve_each",
    "solve_once",
    "solve_with_path",
    "solve_with_points",
    "solve_with_restitutions",
]
