"""Joints with contact, integrated from event to event with SciPy, for the independent models."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp


def contacts(rates, depths, loads, state, duration, rtol=1e-10, max_step=1e-5, samples=200):
    """Integrate, and list the contacts that ended in the order of their starts.

    Parameters
    ----------
    rates : callable
        (t, state, approach) -> rates of the state; `approach` has the speed at which each contact began, None without.
    depths : callable
        (t, state) -> penetrations and their rates, one of each contact.
    loads : callable
        (t, state, approach) -> sizes of the forces, one of each contact.

    Returns
    -------
    (n, 7) array
        Contact's number, start, approach speed, duration, peak force, peak penetration, separation speed.
    """
    number = len(depths(0.0, state)[0])
    t, approach, open_, rows = 0.0, [None] * number, {}, []

    def event(k):
        def depth(t, s):
            return depths(t, s)[0][k]

        depth.terminal, depth.direction = True, 1.0 if approach[k] is None else -1.0
        return depth

    while t < duration:
        run = solve_ivp(
            lambda t, s: rates(t, s, approach), (t, duration), state, "DOP853", rtol=rtol, atol=1e-3 * rtol,
            dense_output=True, max_step=max_step, events=[event(k) for k in range(number)],
        )  # fmt: skip
        assert run.success
        for u in np.linspace(t, run.t[-1], samples) if open_ else ():
            depth, load = depths(u, run.sol(u))[0], loads(u, run.sol(u), approach)
            for k, row in open_.items():
                row[4], row[5] = max(row[4], load[k]), max(row[5], depth[k])
        t, state = run.t[-1], run.y[:, -1]
        depth, closing = depths(t, state)
        for k in range(number):
            together = approach[k] is None and abs(depth[k]) < 1e-13 and closing[k] > 0.0  # SciPy stops at one event
            if not (len(run.t_events[k]) or together):
                continue
            if approach[k] is None:
                approach[k], open_[k] = closing[k], [k, t, closing[k], 0.0, 0.0, 0.0, 0.0]
            else:
                row = open_.pop(k)
                row[3], row[6], approach[k] = t - row[1], -closing[k], None
                rows.append(row)
    return np.array(sorted(rows, key=lambda row: row[1]))
