"""Designs spread over the bounds: `latin_hypercube`."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array


def latin_hypercube(count: int, size: int, rng: np.random.Generator) -> Array:
    """Draw designs (count, size), 0 to 1: each variable has one in each of `count` equal parts of its range.

    The state of the random generator stays the same; each call draws other designs. The numbers are those of
    `scipy.stats.qmc.LatinHypercube`; its import takes as long as several hundred runs of a small machine. M. D. McKay,
    R. J. Beckman, W. J. Conover, A comparison of three methods for selecting values of input variables in the analysis
    of output from a computer code, Technometrics 21(2), 1979.

    Examples
    --------
    >>> import numpy as np
    >>> from optim.algorithms.sampling import latin_hypercube
    >>> designs = latin_hypercube(4, 2, np.random.default_rng(0))
    >>> np.sort(np.floor(4.0 * designs), axis=0).T.tolist()
    [[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0]]
    """
    rng = rng.spawn(1)[0]
    within = rng.uniform(size=(count, size))
    parts = np.tile(np.arange(1, count + 1), (size, 1))
    for one in parts:
        rng.shuffle(one)
    return (parts.T - within) / count
