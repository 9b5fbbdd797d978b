"""Torques of the ideal machine along references, as tables over time: quantities that elements ask for."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.elements.element import IdealEffort
from linkages.elements.machine import DEFINING, functions_of
from linkages.input.functions.definitions import Definition, Quantity, formula, names_in
from linkages.input.model.check import check
from linkages.input.model.experiment import Experiment, experiment_of
from linkages.input.model.mechanism import Mechanism
from linkages.mechanics.planar.closure import BLURRED, follow, follow_branch
from linkages.mechanics.planar.elimination import elimination_of
from linkages.system.assembly import assemble, coordinate_scale, independent
from linkages.system.ideal_linkage import ideal_forces, ideal_linkage
from linkages.system.masses import with_all_masses

_PLACES = 4001  # of each table


def with_feedforward(mechanism: Mechanism, experiment: Experiment) -> dict[str, Quantity]:
    """Return the quantities of an experiment, with the torques of the ideal machine as tables."""
    quantities = dict(experiment.quantities)
    for kind in DEFINING:
        for name, keys in experiment.elements[kind.table].items():
            for wanted in kind.ideal_efforts(keys, name):
                times = np.linspace(0.0, experiment.duration, _PLACES)
                where = f"{kind.table}.{name}.{wanted.key}"
                torques = _torques(mechanism, experiment, where, wanted, times)
                table = times.tolist(), torques.tolist()
                quantities[wanted.quantity] = Quantity(Definition(formula("t"), table=table))
    return quantities


def _torques(mechanism: Mechanism, experiment: Experiment, where: str, wanted: IdealEffort, times: Array) -> Array:
    """Compute the torque or force that moves the ideal machine along the reference (nt,); InputError if it cannot."""
    machine, led = with_all_masses(mechanism, experiment), _led(experiment, wanted)
    check(machine, led)
    one = ideal_linkage(machine, led, led.quantities)
    tree, rows = one.tree, one.tree.closure_rows
    start = assemble(tree, led, one.motions, one.packed)
    if start.mobility != len(tree.driven):
        problem = f"needs drives that, with the reference in {wanted.joint}, determine the whole motion"
        raise InputError(experiment.source, where, problem)
    q, v, a = np.zeros((3, len(times), tree.size))
    for table, values in zip((q, v, a), one.motions(times), strict=True):
        table[:, tree.driven_dofs] = values
    free, quality = tree.closing_dofs, np.zeros(len(times))
    q[0, free] = start.q[free]
    follow(tree.bodies, rows, np.zeros((1, len(rows))), free, tree.extent, q[:1], v[:1], a[:1], quality[:1])
    reached = follow_branch(tree.bodies, rows, free, tree.extent, coordinate_scale(tree), 1, times, q, v, a, quality)
    if reached < len(times) or quality.min() <= BLURRED:
        when = times[min(reached, len(times) - 1)] if reached < len(times) else times[quality.argmin()]
        raise InputError(experiment.source, where, f"the ideal machine is at a dead point at t = {when:.6g} s")
    elimination = elimination_of(tree.bodies, rows, independent(tree, rows, start.q, free), free)
    dof = tree.driven_dofs[tree.driven.index(wanted.joint)]
    states = zip(times.tolist(), q, v, strict=True)
    return np.array([ideal_forces(one, t, at, rates, elimination).tau[dof] for t, at, rates in states])


def _led(experiment: Experiment, wanted: IdealEffort) -> Experiment:
    """Return the ideal experiment whose joint follows the reference, without the loads that quantities give."""
    data = experiment.ideal().model_dump(exclude_unset=True)
    given = experiment.quantities.keys() - experiment.values.keys()
    own = {
        (table, name) for table, name, one in functions_of(experiment.elements) if not given.isdisjoint(names_in(one))
    }
    for table in {table for table, _ in own}:
        data[table] = {name: keys for name, keys in data.get(table, {}).items() if (table, name) not in own}
    defining = (kind.table for kind in DEFINING)
    drives = {**data.get("drives", {}), wanted.joint: {"formula": wanted.reference}}
    return experiment_of(
        experiment.source, data | {"drives": drives, "outputs": [], **{key: {} for key in defining}}, experiment.sources
    )
