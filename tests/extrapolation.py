"""Flights and events in many digits (mpmath), for the oracle: an integrator and a root search.

The integrator is that of Gragg, Bulirsch and Stoer: the midpoint rule with 2, 4, 6, … substeps,
whose error has even powers of the substep only, extrapolated to a substep of zero (Hairer, Nørsett
and Wanner, *Solving Ordinary Differential Equations I*, II.9). An error of a step is the difference
of the last two extrapolations, and is held to what `mpmath.mp.dps` leaves after `SPARE` digits.
"""

from bisect import bisect_left

from mpmath import mp, mpf

SPARE = 15  # digits for the roundings, which the extrapolation multiplies
GROUPS = (slice(0, 3), slice(3, 6), slice(6, 7))  # of a state, with a size each: r, v and the path


def tolerance():
    return mpf(10) ** (SPARE - mp.dps)


def midpoint(slopes, t, y, first, step, parts):
    """State after a step in an even number of parts, with Gragg's last part.

    That one asks for the slopes at the end: no kink of a law may hide behind the last of them.
    """
    part = step / parts
    before, now = y, [a + part * slope for a, slope in zip(y, first, strict=True)]
    for i in range(1, parts):
        rates = slopes(t + i * part, now)
        before, now = now, [a + 2 * part * rate for a, rate in zip(before, rates, strict=True)]
    rates = slopes(t + step, now)
    return [(a + b + part * c) / 2 for a, b, c in zip(before, now, rates, strict=True)]


def distance(a, b, sizes):
    """Largest difference of two states, by the sizes of their groups."""
    return max(
        max(abs(p - q) for p, q in zip(a[group], b[group], strict=True)) / size
        for group, size in zip(GROUPS, sizes, strict=True)
    )


def attempt(slopes, t, y, step, most):
    """State after a step, its error, and the number of extrapolations that it took."""
    first = slopes(t, y)
    sizes = [max(map(abs, y[g])) + abs(step) * max(map(abs, first[g])) or mpf(1) for g in GROUPS]
    row = [midpoint(slopes, t, y, first, step, 2)]
    for count in range(2, most + 1):
        new = [midpoint(slopes, t, y, first, step, 2 * count)]
        for k, coarse in enumerate(row, 1):
            weight = mpf((count - k) ** 2) / (count**2 - (count - k) ** 2)
            new.append([a + (a - b) * weight for a, b in zip(new[-1], coarse, strict=True)])
        row, error = new, distance(new[-1], new[-2], sizes)
        if error <= tolerance():
            break
    return row[-1], error, count


def advance(slopes, t, y, end, step):
    """Yield time, state and the length of the next step, until a time that may lie before."""
    aim = mp.dps // 3
    while t != end:
        left = end - t
        last = abs(step) >= abs(left)
        tried = left if last else mp.sign(left) * abs(step)
        assert t + tried != t, "no step is short enough"
        after, error, count = attempt(slopes, t, y, tried, aim + 2)
        factor = float(tolerance() / max(error, mpf("1e-200"))) ** (1 / (2 * count - 1))
        step = tried * min(4, max(0.02, 0.9 * factor * 1.1 ** (aim - count)))
        if error <= tolerance():
            t, y = (end if last else t + tried), after
            yield t, y, step


class Leg:
    """A flight on one smooth law: known states, and from the nearest one to the time asked."""

    def __init__(self, slopes, t, y):
        self.slopes, self.times, self.states, self.step = slopes, [t], [list(y)], mpf("0.3")

    def at(self, t):
        place = bisect_left(self.times, t)
        near = min(range(len(self.times))[max(place - 1, 0) : place + 1],
                   key=lambda i: abs(self.times[i] - t))  # fmt: skip
        if self.times[near] == t:
            return self.states[near]
        for when, y, step in advance(
            self.slopes, self.times[near], self.states[near], t, self.step
        ):
            place = bisect_left(self.times, when)
            self.times.insert(place, when)
            self.states.insert(place, y)
            self.step = max(abs(step), self.step if when == t else 0)
        return y


def zero(function, low, high):
    """Zero of a function between two times at which its signs differ, by Anderson and Björck.

    A step too short to count ends the search only if the sign changes a hair further: where one
    value is tiny beside the other, steps are short although the zero is far. Then it halves.
    """
    left, right = function(low), function(high)
    assert left * right <= 0, "no zero lies between"
    close = tolerance() * (1 + abs(high)) / 1000
    for _ in range(500):
        if right == 0 or abs(high - low) <= close:
            return high
        if left == 0:
            return low
        new = high - right * (high - low) / (right - left)
        if abs(new - high) <= close:
            if function(high + mp.sign(low - high) * close) * right <= 0:
                return new
            new = (low + high) / 2
        value = function(new)
        if value * right < 0:
            low, left = high, right
        else:
            share = 1 - value / right
            left *= share if share > 0 else mpf("0.5")
        high, right = new, value
    raise AssertionError("no zero found")
