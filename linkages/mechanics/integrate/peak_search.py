"""The search for the highest value of a curve between its samples, and integrals over the samples.

The curve is known at samples, and can be evaluated at any time. Two callers share the search, so that they find the
same numbers: compiled code, which evaluates one time after the other, and Python, which evaluates the times of many
searches at once. Each asks `next_time`, evaluates the curve there, and tells `take`, until there is no next time.
"""

from __future__ import annotations

import math

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel

#: Rows of a search, (3, 3): times and values of the samples around its highest one, and its course.
TIMES, VALUES, COURSE = range(3)
#: Entries of the course: height that the parabola promises at the next time, NaN at the middle of a half; whether the
#: last promise was kept, `_MISSED` if not; number of parabolas.
_PROMISED, _KEPT, _ROUND = range(3)
_MISSED = -1.0

#: Most local maxima that are refined, and so many of them although their parabolas promise less than is found: at kinks
#: parabolas promise too little.
MOST, FEW = 12, 2
_NEAR = 0.01  # largest deficit of these against the best sample, over the range of the values
_ALIKE = 1e-4  # difference of promises over the range of the values up to which the first one is refined first
_ROUNDS = 24  # of parabolas; smooth maxima take two or three, jumps all
_TRIES = 3  # parabolas after which a maximum must be above its floor
_INSIDE = 0.02  # of a bracket's half: a new sample keeps so far from the old ones
_PART = 0.1  # of a parabola's promise: a sample that departs more from it is near a jump or a kink
_FLAT = 1e-10  # relative gain that a parabola promises, after one that kept its promise, at which a maximum is known
_CLOSE = 1e-5  # of a bracket: a next time that is so near to the highest sample adds nothing

#: Just before a time, in parts of it: before the rounding of sampling times.
BEFORE = 1.0 - 1e-12

_EQUAL = 1e-8  # relative difference of maxima that count as equal


@kernel
def parabola_top(a: float, b: float, c: float, fa: float, fb: float, fc: float) -> tuple[float, float]:
    """Compute place and height of the maximum of the parabola through three ordered points; else the middle point."""
    left, right = (fb - fa) / (b - a), (fc - fb) / (c - b)
    curvature = (right - left) / (c - a)
    if not curvature < 0.0:
        return b, fb
    slope = left + curvature * (b - a)  # at b
    shift = -0.5 * slope / curvature
    return b + shift, fb + 0.5 * slope * shift


@kernel
def above(highest: float) -> float:
    """Return the value that a maximum exceeds which is not equal to the highest before it."""
    return highest + _EQUAL * abs(highest)


@kernel
def candidates(times: Array, values: Array, sign: float, places: Indices, tops: Array) -> int:
    """Find the local maxima of sign * values that may be the highest between the samples, the most promising first.

    Of maxima that promise nearly the same, as in a periodic motion, the first is the first of all. Fills ``places`` and
    ``tops`` (MOST,) with the samples and the heights that their parabolas promise; returns how many there are.
    """
    n, count = len(times), 0
    low, high = math.inf, -math.inf
    for i in range(n):
        low, high = min(low, sign * values[i]), max(high, sign * values[i])
    for i in range(n if n > 2 else 0):
        f, left = sign * values[i], min(max(i - 1, 0), n - 3)
        fa, fb, fc = sign * values[left], sign * values[left + 1], sign * values[left + 2]
        if f < fa or f < fb or f < fc:
            continue
        t, top = parabola_top(times[left], times[left + 1], times[left + 2], fa, fb, fc)
        at_end = i != left + 1
        if at_end and not (top > f and times[left] < t < times[left + 2]):
            continue
        if not top >= high - _NEAR * (high - low):
            continue
        place = count
        while place > 0 and tops[place - 1] < top:
            place -= 1
        if place == MOST:
            continue
        count = min(count + 1, MOST)
        for k in range(count - 1, place, -1):
            places[k], tops[k] = places[k - 1], tops[k - 1]
        places[place], tops[place] = i, top
    while count > FEW and not tops[count - 1] > high:
        count -= 1
    lead = 0
    for k in range(1, count):
        if tops[k] >= tops[0] - _ALIKE * (high - low) and places[k] < places[lead]:
            lead = k
    for k in range(lead, 0, -1):
        places[k - 1], places[k], tops[k - 1], tops[k] = places[k], places[k - 1], tops[k], tops[k - 1]
    return count


@kernel
def begin(search: Array, times: Array, values: Array, sign: float, place: int) -> None:
    """Begin a search around the sample at a place, between its neighbours."""
    left = min(max(place - 1, 0), len(times) - 3)
    for k in range(3):
        search[TIMES, k], search[VALUES, k], search[COURSE, k] = times[left + k], sign * values[left + k], 0.0


@kernel
def next_time(search: Array, floor: float) -> float:
    """Return the next time at which a search needs the value; NaN if it has ended.

    It ends if the maximum is known, or lower than the floor. Where a parabola's promise is not kept, at a jump or a
    kink, the middle of the longer half is looked at too. If the highest sample is at an end, one look decides whether
    there is a maximum inside.
    """
    times, values, course = search[TIMES], search[VALUES], search[COURSE]
    a, b, c, highest = times[0], times[1], times[2], values[1]
    if course[_KEPT] == _MISSED:
        course[_PROMISED] = math.nan
        return 0.5 * (b + c) if c - b > b - a else 0.5 * (a + b)
    if course[_ROUND] >= _ROUNDS or (course[_ROUND] >= _TRIES and highest <= floor):
        return math.nan
    t, promised = parabola_top(a, b, c, values[0], highest, values[2])
    course[_PROMISED] = promised
    if highest < max(values[0], values[2]):
        return t if course[_ROUND] == 0.0 and a < t < c else math.nan
    t = min(max(t, a + _INSIDE * (b - a)), c - _INSIDE * (c - b))
    kept = course[_KEPT] > 0.0
    if (kept and (promised - highest <= _FLAT * abs(highest) or promised <= floor)) or abs(t - b) < _CLOSE * (c - a):
        return math.nan
    return t


@kernel
def take(search: Array, t: float, value: float) -> None:
    """Give a search the value at its next time: the highest sample stays in the middle."""
    times, values, course = search[TIMES], search[VALUES], search[COURSE]
    before, promised, ends = values[1], course[_PROMISED], max(values[0], values[2])
    if promised != promised:  # the middle of a half
        course[_KEPT] = 0.0
    else:
        course[_ROUND] += 1.0
        if before < ends:
            promised = math.nan
            if value <= ends:
                return
        elif value == before:  # a plateau, such as the force of a free journal: its end promises more
            course[_ROUND] = _ROUNDS
            return
    end = 0 if t < times[1] else 2
    if value > before:
        times[2 - end], values[2 - end] = times[1], before
        end = 1
    times[end], values[end] = t, value
    if promised == promised:
        kept = abs(value - promised) <= _PART * (promised - before) + _FLAT * abs(values[1])
        course[_KEPT] = 1.0 if kept else _MISSED


@kernel
def integrate_samples(times: Array, values: Array, square: bool) -> float:
    """Integrate values (n,) over times (n,), or their squares, by parabolas through neighbouring samples.

    At a time that occurs twice the values jump.
    """
    n, total, first = len(times), 0.0, 0
    slope, bend = 0.0, 0.0  # of the interval, and half the second derivative at its start
    for i in range(n - 1):
        h, f0, f1 = times[i + 1] - times[i], values[i], values[i + 1]
        if h == 0.0:
            first, bend = i + 1, 0.0
            continue
        if square:
            f0, f1 = f0 * f0, f1 * f1
        slope, after = (f1 - f0) / h, 0.0
        if i + 2 < n and times[i + 2] > times[i + 1]:
            wide, f2 = times[i + 2] - times[i + 1], values[i + 2]
            if square:
                f2 = f2 * f2
            after = ((f2 - f1) / wide - slope) / (wide + h)
            if i == first:
                bend = after
        elif i > first:
            after = bend
        total += h * (0.5 * (f0 + f1) - h * h * (bend + after) / 12.0)
        bend = after
    return total


@kernel
def doubtful(times: Array, values: Array, limit: float, marks: Indices) -> int:
    """Mark the intervals (n - 1,) that need a value in their middle with 1, others with 0; return how many need one.

    They are those whose two parabolas differ in their integrals by more than a limit, in parts of the integral of the
    magnitude: at kinks, and where few samples follow a short force. An interval that they leave alone, beside another
    one, the first or last sample or a jump, needs one too.
    """
    n, size = len(times), 0.0
    for i in range(n - 1):
        size += 0.5 * (times[i + 1] - times[i]) * (abs(values[i]) + abs(values[i + 1]))
    for i in range(n - 1):
        h, before, after = times[i + 1] - times[i], _bend(times, values, i), _bend(times, values, i + 1)
        differ = h * h * h * abs(after - before) > 12.0 * limit * size  # not at ends and jumps, where one is NaN
        marks[i] = 1 if differ else 0
    count = 0
    for i in range(n - 1):
        divided = (i > 0 and marks[i - 1] == 1) or (i < n - 2 and marks[i + 1] == 1)
        if divided and _begins(times, marks, i) and _ends(times, marks, i) and times[i + 1] > times[i]:
            marks[i] = 1  # alone it would have no parabola
        count += marks[i]
    return count


@inlined_kernel
def _begins(times: Array, marks: Indices, i: int) -> bool:
    """Whether no parabola passes through the begin of interval i."""
    return i == 0 or marks[i - 1] == 1 or times[i] == times[i - 1]


@inlined_kernel
def _ends(times: Array, marks: Indices, i: int) -> bool:
    """Whether no parabola passes through the end of interval i."""
    return i == len(marks) - 1 or marks[i + 1] == 1 or times[i + 2] == times[i + 1]


@kernel
def _bend(times: Array, values: Array, i: int) -> float:
    """Return half the second derivative of the parabola around sample i; NaN without one."""
    if i == 0 or i == len(times) - 1:
        return math.nan
    before, after = times[i] - times[i - 1], times[i + 1] - times[i]
    if not (before > 0.0 and after > 0.0):
        return math.nan
    return ((values[i + 1] - values[i]) / after - (values[i] - values[i - 1]) / before) / (before + after)


@kernel
def middle(times: Array, i: int) -> float:
    """Return the middle of interval i."""
    return 0.5 * (times[i] + times[i + 1])


@kernel
def add_middles(times: Array, values: Array, marks: Indices, middles: Array, more: Array, found: Array) -> int:
    """Fill samples (4 n,) with those (n,) given and the middles (n - 1,) of marked intervals; return how many.

    Each marked interval has a parabola of its own, as between jumps. Middles without a value are left out.
    """
    count = 0
    for i in range(len(times)):
        more[count], found[count] = times[i], values[i]
        count += 1
        if i == len(marks) or marks[i] == 0 or not math.isfinite(middles[i]):
            continue
        if count > 1 and more[count - 2] < times[i]:
            more[count], found[count] = times[i], values[i]
            count += 1
        more[count], found[count] = middle(times, i), middles[i]
        more[count + 1], found[count + 1] = times[i + 1], values[i + 1]
        count += 2
    return count


@kernel
def average(times: Array, values: Array, square: bool) -> float:
    """Return the mean over time of values (n,), or their root mean square; of one sample itself."""
    n = len(times)
    span = times[n - 1] - times[0]
    if not span > 0.0:
        return abs(values[n - 1]) if square else values[n - 1]
    mean = integrate_samples(times, values, square) / span
    return math.sqrt(max(mean, 0.0)) if square else mean
