"""Latin hypercubes, equal to those of `scipy.stats.qmc`, which takes more than a second to import."""

from __future__ import annotations

import numpy as np

from optim.algorithms.nlp import Array


def latin_hypercube(count: int, size: int, random: np.random.Generator) -> Array:
    """Choose points of the unit cube: each of `count` equal parts of each axis has one.

    M. D. McKay, R. J. Beckman, W. J. Conover, A comparison of three methods for selecting values of input variables in
    the analysis of output from a computer code, Technometrics 21 (1979) 239-245.

    Parameters
    ----------
    count, size : int
        Number of points m, and of axes n.
    random : Generator
        Gives a child; its own state stays.

    Returns
    -------
    (m, n) array
        In [0, 1).

    Examples
    --------
    >>> import numpy as np
    >>> from optim.algorithms.latin_hypercube import latin_hypercube
    >>> np.sort(np.floor(4 * latin_hypercube(4, 2, np.random.default_rng(0))), axis=0).T.tolist()
    [[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0]]
    """
    (child,) = random.spawn(1)
    within = child.uniform(size=(count, size))
    parts = np.tile(np.arange(1, count + 1), (size, 1))
    for line in parts:
        child.shuffle(line)
    return np.asarray((parts.T - within) / count)
