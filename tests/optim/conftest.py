import numpy as np
import pytest

from optim.evaluate.requests import Statistics


def oscillation(request, progress=None):
    """An invented engine: output k in window w swings by a smooth function of the design about another.

    There is no assembly where the first value is above 0.9 of its window's number in the thousands.
    """
    m, nw, no = len(request.values), len(request.windows), len(request.outputs)
    scaled = request.values / (1.0 + np.abs(request.values))
    swing = np.empty((m, nw, no))
    for w, (start, _) in enumerate(request.windows):
        for k in range(no):
            swing[:, w, k] = 1.0 + k + start + ((scaled - 0.1 * (k + 1)) ** 2).sum(axis=1)
    middle = 0.1 * scaled[:, :1, None] * np.ones((1, nw, no))
    rms = np.hypot(middle, swing / np.sqrt(2.0))
    return Statistics(np.stack([middle - swing, middle + swing, middle, rms]), ["ok"] * m, [""] * m)


@pytest.fixture
def invented_engine(monkeypatch):
    monkeypatch.setattr("optim.evaluate.evaluator.run_compiled", oscillation)
    monkeypatch.setattr("optim.search.verification.run_on_drake", oscillation)
    return oscillation
