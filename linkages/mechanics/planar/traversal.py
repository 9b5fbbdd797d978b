"""Forward and backward passes over the tree of bodies: an algorithm is a few functions of one body, passed to these."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from linkages.base.kernel import Indices, inlined_kernel, lazy_kernel
from linkages.mechanics.planar.bodies import Bodies


def forward(visit: Callable[..., Any], moving: bool = True) -> Callable[..., None]:
    """Make a pass that calls ``visit(bodies, i, *given)`` for parents before their children, the world excepted.

    The pass is a kernel ``(bodies, *given)``, inlined into its callers; with `moving` it visits only bodies that a free
    coordinate moves.
    """

    @inlined_kernel
    def sweep(bodies: Bodies, *given: Any) -> None:
        """Visit the bodies in their order."""
        for i in range(1, len(bodies.records)):
            if not moving or bodies.records[i].moving:
                visit(bodies, i, *given)

    return sweep


def backward(visit: Callable[..., Any], moving: bool = True) -> Callable[..., None]:
    """Make a pass that calls ``visit(bodies, i, *given)`` for children before their parents; see `forward`."""

    @inlined_kernel
    def sweep(bodies: Bodies, *given: Any) -> None:
        """Visit the bodies in the reverse of their order."""
        for i in range(len(bodies.records) - 1, 0, -1):
            if not moving or bodies.records[i].moving:
                visit(bodies, i, *given)

    return sweep


#: What a change of some coordinates does to a body: nothing; moves it; nothing, but the change before has moved it.
STILL, MOVED, FREED = range(3)


@lazy_kernel
def mark_moved(bodies: Bodies, changed: Indices, moves: Indices) -> None:
    """Note which bodies move, ``moves`` (nb,), with the coordinates that have 1 in ``changed`` (n,).

    ``moves`` says before which bodies have moved with the coordinates before; at first all of them.
    """
    moves[0] = STILL
    for i in range(1, len(bodies.records)):
        body = bodies.records[i]
        moved = moves[body.mount.body] == MOVED or (body.dof >= 0 and changed[body.dof] == 1)
        for k in range(body.eta, body.eta + body.shapes):
            moved = moved or changed[k] == 1
        moves[i] = MOVED if moved else FREED if moves[i] == MOVED else STILL
