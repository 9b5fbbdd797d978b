"""Loop closure on the branch of the reference configuration, mobility, and the consistent state at t = 0."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array, Indices, Records
from linkages.base.errors import AssemblyError, InputError, Status, listed
from linkages.input.model.experiment import Experiment
from linkages.mechanics.planar.articulated_body import articulated_inertias
from linkages.mechanics.planar.closure import approach, close, closure_quality, consistent_rates, jacobian_at
from linkages.mechanics.planar.elimination import elimination_of
from linkages.mechanics.planar.kinematics import body_positions
from linkages.mechanics.planar.loop_dynamics import eliminate_rows
from linkages.mechanics.planar.motion import Motions
from linkages.mechanics.planar.record_types import ANGLE, PRISMATIC
from linkages.system.load_records import Packed, check_loads
from linkages.system.loose_start import check_within_travel, settle_within_travel, settled_rates, tight_rows
from linkages.system.tree import ROWS, Tree, without

#: Ratio of singular values below which a position counts as singular. At an exact dead point Newton's method computes a
#: ratio of about the square root of `linkages.mechanics.planar.closure.TOLERANCE`.
SINGULAR = 1e-6
_CONTINUATION = 0.05  # largest step of a drive from the reference configuration to its start angle [rad or m]
_FARTHEST = 1e3  # largest start value of a drive [rad or m]
_CLEAR, _CLEARLY = 1e-9, 1e-6  # relative thresholds for independent rows: at a pose, at a neighbouring pose
_ASIDE, _TRIED = (0.05, 0.01), 4  # distances of neighbouring poses [rad, or linkage lengths]; number of directions
_ALIGNED = 1e-9  # component of a direction that counts as zero
_STILL = 1e-9  # largest motion of a joint that counts as none, relative to the motion without gears
_ASTRAY = 0.1  # largest relative deviation of a closed neighbouring pose from the intended direction


class Rank(NamedTuple):
    """Independence of closure rows at a pose."""

    here: int  # independent rows at the pose
    most: int  # most independent rows there and at neighbouring poses
    moves: bool  # whether the linkage can move in every direction that its Jacobian leaves open
    still: NDArray[np.bool_]  # coordinates that its Jacobian leaves open, but that it cannot move, (n,)
    open: NDArray[np.bool_]  # coordinates that its Jacobian leaves open, (n,)

    @property
    def flat(self) -> bool:
        """Check for a rank drop at the pose, as for a four-bar with all links on one line."""
        return self.here < self.most


@dataclass(frozen=True)
class Assembly:
    """A linkage assembled at t = 0 on the branch of the reference configuration (the SDF file's pose).

    Attributes
    ----------
    q, v : (n,) arrays
        Coordinates of the *ideal* linkage (displaced by the joints' offsets), and their rates.
    mobility : int
        Degrees of freedom.
    quality : float
        Smallest over largest singular value of the closure Jacobian's free columns [1]: zero at a singular position,
        NaN where the drives do not determine it.
    """

    q: Array
    v: Array
    mobility: int
    quality: float


def assemble(
    tree: Tree, experiment: Experiment, motions: Motions, packed: Packed, offsets: Array | None = None
) -> Assembly:
    """Assemble the ideal linkage at t = 0 with consistent velocities.

    Drives move from the reference configuration to their start angles in small steps, so that the assembly stays on
    the branch of the SDF file. Coordinates without a prescribed motion keep their reference values as far as the loops
    allow, and have zero velocity; powered joints start at their `angle` and `speed`. If the ideal linkage has fewer
    freedoms than drives, so that these move only within clearances, the loops of ideal joints alone determine the
    speeds. Prescribed motions of loosely coupled joints start anywhere within their travel
    (`linkages.system.loose_start`).
    Journals are displaced by `offsets`, two for each clearance joint (default: the experiment's offsets).

    AssemblyError if the loops cannot be closed or the position is singular. InputError if a drive starts too far from
    the reference configuration, more joints are driven than the linkage has degrees of freedom, or a spring has no
    direction at t = 0.
    """
    moved = np.concatenate([tree.driven_dofs, tree.powered_dofs])
    value, rate = motions.start
    powered = [experiment.drives[name] for name in tree.powered]
    start = np.concatenate([value, [drive.angle for drive in powered]])
    for name, distance in zip([*tree.driven, *tree.powered], start, strict=True):
        if not abs(distance) <= _FARTHEST:
            problem = f"starts {distance:g} rad or m from the reference configuration; the limit is {_FARTHEST:g}"
            raise InputError(experiment.source, f"drives.{name}", problem)
    speed = np.concatenate([rate, [drive.speed or 0.0 for drive in powered]])
    rows, size = tree.closure_rows, tree.extent
    none = np.zeros(len(rows))
    q, v = np.zeros(tree.size), np.zeros(tree.size)
    held, held_free, through_play, forced = moved, False, False, False
    free = without(tree.closing_dofs, held)
    closed = close(tree.bodies, rows, none, free, size, q)
    if not closed and tree.powered and (tree.play or tree.loose):  # they may move only within clearances
        q[:] = 0.0
        closed = held_free = close(tree.bodies, rows, none, tree.closing_dofs, size, q)
    if closed:
        drawn, rank = q.copy(), _drawn_rank(tree, rows, q)
        if through_play := _moves_through_play(tree, experiment, len(tree.joint_dofs) - rank.most, q):
            held = tree.driven_dofs
            free = without(tree.closing_dofs, held)
            forced = len(held) > len(tree.joint_dofs) - rank.most
        places = start[: len(held)]
        if forced:
            closed = settle_within_travel(tree, free, none, held, places, continuation(places), q)
        else:
            closed = (through_play or not held_free) and approach(
                tree.bodies, rows, free, size, held, start, continuation(start), q
            )
    if not closed:
        at = ", ".join(f"{tree.coordinates[i]} = {q[i]:.4g}" for i in held) or "the reference configuration"
        raise AssemblyError(Status.NO_ASSEMBLY, f"the loops do not close at {at}{_widest_gap(tree, q)}")
    rank = rank if forced or np.array_equal(q, drawn) else _rank(tree, rows, q)
    mobility = len(tree.joint_dofs) - rank.most
    if not through_play:
        _check_count(tree, experiment, len(held), mobility, q)
    offset = start_offsets(tree, experiment)
    if offsets is not None:
        offset[: 2 * len(tree.play)] = offsets
    if forced:
        settle_within_travel(tree, free, offset, held, places, 0, q)
        check_within_travel(tree, experiment, q)
    elif np.any(offset) and not close(tree.bodies, rows, offset, free, size, q):
        raise AssemblyError(Status.NO_ASSEMBLY, "the loops do not close with these journal offsets")
    rank = _rank(tree, rows, q) if np.any(offset) and not forced else rank
    quality = closure_quality(tree.bodies, rows, free, q)
    determined = mobility == len(held)
    v[moved] = speed
    if through_play:
        rows, free = tree.loop_rows, without(free, moved)
    if forced:
        settled_rates(tree, free, q, v)
    else:
        consistent_rates(tree.bodies, rows, free, q, v, np.zeros(tree.size))
    if (determined and quality < SINGULAR) or rank.flat:
        raise AssemblyError(Status.SINGULAR, f"the start position is singular{_slides(tree)}")
    check_loads(tree, experiment, packed, motions, q, v)
    return Assembly(q, v, mobility, quality if determined else float("nan"))


def continuation(start: Array) -> int:
    """Return the number of steps in which drives move to their start (nd,) [rad, m]."""
    return int(np.ceil(np.max(np.abs(start), initial=0.0) / _CONTINUATION))


def start_offsets(tree: Tree, experiment: Experiment) -> Array:
    """Return the values (nr,) of the closure rows at the start: journals' offsets, places in free travels [m, rad]."""
    given = [x for name in tree.play for x in experiment.joints[name].offset]
    given += [tree.seen_coordinate(one.joints[1], one.carrier)[1] * one.start for one in tree.loose.values()]
    return np.array(given + [0.0] * (len(tree.closure_rows) - len(given)))


def _widest_gap(tree: Tree, q: Array) -> str:
    """Name the cut joint that stays farthest open at q."""
    rows, gap = tree.closure_rows, np.abs(tree.gaps(q))
    play, loops = (
        [n for n in cut for _ in range(ROWS[tree.mechanism.joint[n].type])] for cut in (tree.play, tree.loops)
    )
    loose, coupled = ([one.label for one in some.values()] for some in (tree.loose, tree.coupled))
    owner = [*play, *loose, *loops, *coupled]
    widest = int(np.argmax(gap))
    unit = "rad" if rows["term"]["kind"][widest] == ANGLE else "m"
    return f": {owner[widest]} stays open by {gap[widest]:.3g} {unit}"


def _moves_through_play(tree: Tree, experiment: Experiment, mobility: int, q: Array) -> bool:
    """Check whether drives move only within clearances: the ideal linkage has fewer freedoms, its mobility."""
    drives = len(tree.driven) + len(tree.powered)
    if drives <= mobility or not (tree.play or tree.loose):
        return False
    _check_count(tree, experiment, drives, len(tree.joint_dofs) - independent(tree, tree.loop_rows, q), q)
    if len(tree.driven) > len(tree.joint_dofs) - independent(tree, tight_rows(tree), q):
        _check_count(tree, experiment, drives, mobility, q)  # prescribed motions would force journals through bearings
    for name in tree.powered:
        if experiment.drives[name].angle:
            problem = "must be zero or left out: the ideal linkage locks this joint, which moves only within clearances"
            raise InputError(experiment.source, f"drives.{name}.angle", problem)
    return True


def _check_count(tree: Tree, experiment: Experiment, drives: int, mobility: int, q: Array) -> None:
    if drives > mobility:
        if tree.coupled and (locking := locking_couplings(tree, tree.closure_rows, q)):
            named = [*tree.coupled]
            tables = dict.fromkeys(table for table, name in experiment.named if name in {named[k] for k in locking})
            problem = "contradict each other, or the loops: their joints cannot move; correct a ratio, or remove one"
            where = f"{listed(tables)}: {listed(named[k] for k in locking)}"
            raise InputError(experiment.source, where, problem)
        freedoms = f"{mobility} degree{'' if mobility == 1 else 's'} of freedom"
        counted = f"{drives} drive{'' if drives == 1 else 's'}"
        problem = (
            f"{counted} for {freedoms} of {tree.mechanism.name}{'' if mobility else _slides(tree)}; drive fewer joints"
        )
        raise InputError(experiment.source, "drives", problem)


def _slides(tree: Tree) -> str:
    """Tell the directions of prismatic joints, which files give by mistake or by default; empty without any."""
    slides = {joint.name: joint.direction for joint in tree.mechanism.joints if joint.type == "prismatic"}
    if not slides:
        return ""
    said = listed(f"{name} slides {_along(*direction)}" for name, direction in slides.items())
    return f' ({said}; for another direction change the axis, in a description "along ground at 90 deg")'


def _along(x: float, y: float) -> str:
    """Tell a direction in the plane."""
    if min(abs(x), abs(y)) < _ALIGNED:
        return "along x" if abs(y) < _ALIGNED else "along y"
    return f"at {np.degrees(np.arctan2(y, x)) % 180.0:.4g} degrees to x"


def _drawn_rank(tree: Tree, rows: Records, q: Array) -> Rank:
    """Reject a reference configuration at a bifurcation, or one in which the closed loops block every motion."""
    rank = _rank(tree, rows, q)
    if rank.flat:
        raise AssemblyError(Status.SINGULAR, "two motions branch at the reference configuration; draw another pose")
    if not rank.moves:
        problem, still = "the links are just long enough to close the loops: ", rank.still
        if np.array_equal(still, rank.open) or not still.any():
            raise AssemblyError(Status.LOCKED, f"{problem}the reference configuration is immobile{_slides(tree)}")
        names = listed(name for name, stuck in zip(tree.coordinates, still, strict=True) if stuck)
        raise AssemblyError(Status.LOCKED, f"{problem}{names} cannot move, wherever the other joints are")
    return rank


def independent(tree: Tree, rows: Records, q: Array, columns: Indices | None = None) -> int:
    """Count the independent rows at q and at neighbouring poses, in some coordinates (default: the joints')."""
    return _rank(tree, rows, q, columns).most


def _rank(tree: Tree, rows: Records, q: Array, columns: Indices | None = None) -> Rank:
    """Count the independent rows in some columns (default: the joints'); if not all are, at neighbouring poses too."""
    columns = tree.joint_dofs if columns is None else columns
    jacobian = jacobian_at(tree.bodies, rows, q)
    here = found = _count(jacobian[:, columns], _CLEAR)
    if found == min(len(rows), len(columns)):
        none = np.zeros(tree.size, dtype=bool)
        return Rank(found, found, True, none, none)
    every = np.union1d(columns, tree.joint_dofs)
    still = np.linalg.svd(jacobian[:, every])[2][_count(jacobian[:, every], _CLEAR) :]
    ways = np.zeros((len(still), tree.size))
    ways[:, every] = still
    none, dice = np.zeros(len(rows)), np.random.default_rng(0)
    scale = coordinate_scale(tree)
    moves, free = True, np.abs(ways / scale).max(axis=0, initial=0.0) > _CLEAR
    still = free.copy()
    for _ in range(_TRIED if len(ways) else 0):
        way = dice.standard_normal(len(ways)) @ ways
        reached = False
        for distance in _ASIDE:
            aside = distance * way / np.abs(way / scale).max()
            beside = q + aside
            if not close(tree.bodies, rows, none, every, tree.extent, beside):
                continue
            found = max(found, _count(jacobian_at(tree.bodies, rows, beside)[:, columns], _CLEARLY))
            still &= np.abs((beside - q) / scale) < _ASTRAY * distance
            astray = ways @ (beside - q - aside)
            reached = reached or bool(np.linalg.norm(astray) < _ASTRAY * np.linalg.norm(aside))
        moves = moves and reached
    return Rank(here, found, moves, still, free)


def coordinate_scale(tree: Tree) -> Array:
    """Return the size (n,) of a large change of each coordinate: 1 rad, or the linkage's length [m]."""
    scale = np.ones(tree.size)
    scale[tree.bodies.records["dof"][tree.bodies.records["type"] == PRISMATIC]] = tree.extent
    return scale


def balanced(tree: Tree, rows: Records, q: Array) -> Records:
    """Scale the rows of angles and couplings so that unit reactions give, on average, the same response as length rows.

    Without this scaling a light slider, a light wheel or a large gear ratio would be mistaken for a singular position.
    Couplings are scaled one by one; all angle rows share one factor.
    """
    coupled = rows["ratio"] != 0.0
    angles = ~coupled & (rows["term"]["kind"] == ANGLE)
    if not (coupled | angles).any():
        return rows
    work = tree.workspace(rows)
    work.q[:] = q
    body_positions(tree.bodies, q, work.pose)
    articulated_inertias(tree.bodies, work)
    eliminate_rows(tree.bodies, rows, elimination_of(tree.bodies, rows, 0, tree.free_dofs), work)
    moved = work.pivots.diagonal.copy()
    moved[angles] = moved[angles].max(initial=0.0)
    lengths = moved[~coupled & ~angles & (moved > 0.0)]
    usual, scaled = np.exp(np.log(lengths).mean()) if lengths.size else 1.0, (coupled | angles) & (moved > 0.0)
    rows = rows.copy()
    rows["scale"][scaled] = np.sqrt(usual / moved[scaled])
    return rows


def _count(jacobian: Array, part: float) -> int:
    """Count the singular values above a part of the largest entry."""
    if not jacobian.size:
        return 0
    return int(np.count_nonzero(np.linalg.svd(jacobian, compute_uv=False) > part * np.abs(jacobian).max()))


def locking_couplings(tree: Tree, rows: Records, q: Array) -> list[int]:
    """Find the couplings, by index, that keep joints from moving which loops and fewer couplings let move.

    The closure rows, of couplings last, are `Tree.closure_rows`, or `Tree.loop_rows` if joints have clearance; q (n,)
    is a regular position. Without one of these couplings, the joints of another one could move.
    """
    every = range(len(tree.coupled))
    stuck = [k for k in every if _moves(tree, rows, q, (), k) and not _moves(tree, rows, q, every, k)]
    if len(stuck) < 2:
        return stuck
    return [k for k in stuck if any(_moves(tree, rows, q, [i for i in every if i != k], j) for j in stuck if j != k)]


def _moves(tree: Tree, rows: Records, q: Array, kept: Collection[int], one: int) -> bool:
    """Tell whether a joint of a coupling can move with closed loops and some of the couplings."""
    loops = len(rows) - len(tree.coupled)
    kept_rows: Sequence[int] = [*range(loops), *(loops + k for k in kept)]
    ends = np.repeat(rows[loops + one : loops + one + 1], 2)
    ends["term"][1], ends["ratio"] = ends["other"][1], 0.0
    joints, columns = jacobian_at(tree.bodies, ends, q), tree.joint_dofs
    closed = jacobian_at(tree.bodies, rows[kept_rows], q)[:, columns]
    values, right = np.linalg.svd(closed)[1:] if len(closed) else (np.empty(0), np.eye(len(columns)))
    open_ways = right[int(np.count_nonzero(values > _STILL * values.max(initial=0.0))) :]
    return bool(np.abs(joints[:, columns] @ open_ways.T).max(initial=0.0) > _STILL)
