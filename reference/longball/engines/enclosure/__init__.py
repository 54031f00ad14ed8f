r"""The enclosure engine: flights in ball arithmetic, with a proof in every step.

Numbers are balls, a midpoint and a radius that holds every rounding (python-flint's `arb`). What
ball arithmetic cannot know is the error of cutting a Taylor series off. It is bounded as follows,
for any law that is traced (`longball.model.trace`); each bound is a function in `lemmas`, with its
proof.

**The core** is those variables that rates depend on: the velocity, under the paper's law. Let
``v' = f(v)`` be its equations. The other variables are integrals of it.

**The defect.** Let p be polynomials in time with exact coefficients: here those of the Taylor
series (`longball.engines.series`), but how they were found does not matter. The sums and products
of which f is made are polynomials again. For every other node of f, a root, a quotient, an
exponential or a logarithm, there is another polynomial, which misses the equation that the node
obeys (``N² = a``, ``N b = a``, ``N' = a' N``, ``a N' = a'``) by a *residual*, a polynomial. So N is
off by a bounded error, later nodes propagate it, and ``|p' - f(p)| <= δ``. Everything is bounded by
the sizes of the terms of polynomials.

**The error** e = v - p obeys ``|e|' <= λ |e| + δ``, where λ bounds the largest eigenvalue of the
symmetric part of f's derivative near p (the logarithmic norm); hence
``|e(t)| <= (|e(0)| + δ t) exp(∫ max(λ, 0))``. Neither an a-priori box nor a Taylor coefficient over
a box is needed; the speed may be zero; and the error of a step is propagated as one number, which
grows only if nearby flights part.

**An event** is located by the search that all engines share (`longball.engines.event`), on pieces
that are polynomials with balls as coefficients (`curve`). What is open when parts are tiny is
`Undecided`.
"""

from longball.engines.enclosure.balls import Balls as Balls
from longball.engines.enclosure.engine import Enclosure as Enclosure
