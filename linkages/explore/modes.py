"""Natural frequencies and mode shapes of a linkage at rest, with fixed drives.

The equations of motion of the compiled engine are linearised about a pose: M x'' + C x' + K x = 0, where x are the
changes of coordinates that keep the loops closed. K has the stiffness of flexible links and springs, the change of
weight and applied loads with the pose, and the geometric stiffness of the forces that they cause at rest. Prescribed
joints are fixed, clearance joints are ideal, velocities are zero: there are no gyroscopic and centrifugal terms.
Friction, stops and contacts are omitted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from linkages.base.arguments import validated
from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.elements.flexible.substructure import Substructure
from linkages.engines.compiled.run.linear import linearised
from linkages.engines.compiled.run.runner import Runner
from linkages.explore.numerics import MODES_AT_REST, MODES_SAMPLES, MODES_SPARE, MODES_SYMMETRIC, MODES_ZERO
from linkages.mechanics.flexible.modes import ModesAt, track
from linkages.mechanics.planar.bodies import ELASTIC, STIFFNESS, make_motion
from linkages.mechanics.planar.kinematics import body_velocities, poses_at
from linkages.system import System
from linkages.system.linear_systems import StaticSystem, static_systems


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of a linkage in a pose, in increasing frequency; m modes, n free coordinates; made by `modes`.

    Attributes
    ----------
    system : StaticSystem
        The linkage in its pose.
    squares : (m,) array
        Squares p^2 of the angular frequencies of the undamped linkage [(rad/s)^2]: zero for a free motion, negative if
        the pose is unstable.
    damping : (m,) array
        Damping ratio of each mode [1], without coupling of modes; NaN without a frequency.
    shapes : (n, m) array
        Changes of the free coordinates, for unit modal mass.
    mass : (n, n) array
        Mass matrix of the free coordinates.
    conservative : bool
        Whether the stiffness matrix is symmetric. Otherwise the frequencies include the antisymmetric part (loads that
        follow a link or a formula), and eigenvalues may be complex: then their real parts are given.
    at_rest : bool
        Whether the pose is an equilibrium.
    """

    system: StaticSystem
    squares: Array
    damping: Array
    shapes: Array
    mass: Array
    conservative: bool
    at_rest: bool

    @property
    def frequencies(self) -> Array:
        """Return the natural frequencies (m,) [Hz]; zero for a free motion, NaN for an unstable mode."""
        with np.errstate(invalid="ignore"):
            found: Array = np.sqrt(self.squares) / (2.0 * np.pi)
        return found

    def full(self) -> Array:
        """Return the changes of all coordinates (number of coordinates, m); zero for prescribed joints."""
        found = np.zeros((self.system.tree.size, self.shapes.shape[1]))
        found[self.system.tree.free_dofs] = self.shapes
        return found

    def strain(self) -> dict[str, Array]:
        """Return each flexible link's share of the total strain energy in each mode (m,)."""
        tree, full = self.system.tree, self.full()
        energy = {}
        for name, substructures in tree.deformable.items():
            energy[name] = np.zeros(full.shape[1])
            for part in substructures:
                body = tree.index[part.name]
                eta = int(tree.bodies.records[body]["eta"]) + np.arange(part.size)
                stiffness = tree.bodies.shapes[body, ELASTIC, : len(eta), STIFFNESS]
                energy[name] += 0.5 * stiffness @ full[eta] ** 2
        total = sum(energy.values(), np.zeros(full.shape[1]))
        return {name: part / np.where(total > 0.0, total, 1.0) for name, part in energy.items()}


@dataclass(frozen=True, eq=False)
class ModesOver:
    """Modes of a linkage in N poses, followed from pose to pose by the modal assurance criterion (MAC)."""

    times: Array  # (N,) times at which the drives reach the poses [s]
    frequencies: Array  # (N, m) natural frequencies [Hz]; NaN for an unstable mode
    mac: Array  # (N - 1, m) smallest MAC within each step; close to 1 if a mode is followed reliably


@validated
def modes(system: System, time: float = 0.0) -> Modes:
    """Compute the modes of a linkage at rest in the pose at a time.

    For frequencies over the motion use `linkages.explore.modes.modes_over`.

    Parameters
    ----------
    system : System
    time : float
        Time of the pose [s]; other than 0 only if prescribed drives determine the motion.

    Raises
    ------
    InputError
        If nothing can move, or loads buckle a link at rest.
    AssemblyError
        If the linkage cannot be assembled.

    Examples
    --------
    >>> import linkages
    >>> found = linkages.modes(linkages.load(linkages.find_file("slider_crank_flexible.toml")))
    >>> found.frequencies[:2].round(1)  # Hz
    array([203.2, 813.3])
    """
    return _modes(static_systems(system, [time])[0])


def modes_over(
    system: System, times: Sequence[float], count: int, progress: Callable[[float], None] | None = None
) -> ModesOver:
    """Follow the lowest modes over the poses that prescribed drives reach at increasing times [s], each at rest."""

    def at(pose: StaticSystem) -> ModesAt:
        found = _modes(pose)
        kept = slice(0, count + MODES_SPARE)
        return ModesAt(pose.time, found.frequencies[kept], found.shapes[:, kept], found.mass)

    def found() -> Iterator[ModesAt]:
        for k, pose in enumerate(static_systems(system, times)):
            yield at(pose)
            if progress is not None:
                progress((k + 1) / len(times))

    values, _, mac = track(found(), lambda time: at(static_systems(system, [time])[0]), count)
    return ModesOver(np.array(times), values.astype(np.float64), mac.astype(np.float64))


def _modes(pose: StaticSystem) -> Modes:
    matrices = linearised(Runner(pose), pose.time)
    if not matrices.ways.size:
        problem = "has no modes: no link is flexible, and its drives fix all joints"
        raise InputError(pose.description.source, "links", f'{problem}; set links.NAME.model = "flexible"')
    inverse = np.linalg.inv(np.linalg.cholesky(matrices.mass))
    standard = inverse @ matrices.stiffness @ inverse.T
    size, twist = np.abs(standard).max(), np.abs(standard - standard.T).max()
    conservative = bool(twist <= MODES_SYMMETRIC * size)
    if conservative:
        squares, found = np.linalg.eigh(0.5 * (standard + standard.T))
    else:
        values, vectors = np.linalg.eig(standard)
        order = np.argsort(values.real)
        squares, found = values.real[order], vectors.real[:, order]
        found /= np.linalg.norm(found, axis=0)
    squares = np.where(np.abs(squares) <= MODES_ZERO * np.abs(squares).max(), 0.0, squares)
    reduced = inverse.T @ found
    swinging = squares > 0.0
    rates = np.sqrt(np.where(swinging, squares, np.nan))
    ratios = 0.5 * np.einsum("im,ij,jm->m", reduced, matrices.damping, reduced) / rates
    pull = np.linalg.inv(reduced) @ matrices.acceleration
    away = np.abs(matrices.ways @ reduced[:, swinging]) * np.abs(pull[swinging] / squares[swinging])
    drifts = np.abs(pull[~swinging]).max(initial=0.0) > MODES_AT_REST * np.abs(pull).max(initial=1.0)
    at_rest = bool(away.max(initial=0.0) <= MODES_AT_REST * max(pose.tree.extent, 1.0)) and not drifts
    return Modes(pose, squares, ratios, matrices.ways @ reduced, matrices.masses, conservative, at_rest)


class ModeLine(NamedTuple):
    """A line of a link: name, colour, n points (n, 2) [m], and displacements (m, n, 2)."""

    link: str
    color: str
    places: Array
    ways: Array


class ModeShapes:
    """Displacements in the m modes of a linkage, scaled so that no point of a line moves farther than 1.

    Lines of flexible links are sampled along their beams; rigid links are the bars between their joints and frames.
    `scale` (m,) is the factor on the shapes of unit modal mass; its square is the modal mass of the scaled shape.
    """

    def __init__(self, modes: Modes) -> None:
        self._system, self._changes = modes.system, modes.full()
        bodies = self._system.tree.bodies
        self._pose = poses_at(bodies, self._system.assembly.q)
        moved = []
        for change in self._changes.T:
            motion = make_motion(bodies)
            body_velocities(bodies, self._pose, np.ascontiguousarray(change), motion)
            moved.append(motion)
        self._moved = np.array(moved)
        lines = list(self._lines())
        largest = np.max([np.linalg.norm(line.ways, axis=2).max(axis=1) for line in lines], axis=0)
        self.scale: Array = 1.0 / np.where(largest > 0.0, largest, 1.0)
        self.lines = [line._replace(ways=line.ways * self.scale[:, None, None]) for line in lines]

    def points(self) -> dict[str, Array]:
        """Return displacements along x and y, and turns, of all links' and frames' origins, (3, m) each."""
        found = {}
        for name in self._system.points:
            body, x, y = self._system.tree.named_marker(name)
            arms = _turned(self._pose[body, 2], np.array([[x, y]]))
            turn = self._moved[:, body, 0]
            found[name] = np.vstack([self._displaced(body, arms)[:, 0].T, turn]) * self.scale
        return found

    def _lines(self) -> Iterator[ModeLine]:
        tree = self._system.tree
        for link in tree.links.values():
            shape = tree.skeleton(link.name)
            if link.name in tree.deformable:
                bodies = (body for body in tree.deformable[link.name] if isinstance(body, Substructure))
                yield from (self._beam(link.name, shape.color, body) for body in bodies)
                continue
            body = tree.index[link.name]
            arms = _turned(self._pose[body, 2], shape.places - tree.drawn[body])
            places, ways = self._pose[body, :2] + arms, self._displaced(body, arms)
            for bar in shape.bars or ((0, 0),):
                yield ModeLine(link.name, shape.color, places[list(bar)], ways[:, list(bar)])

    def _beam(self, link: str, color: str, part: Substructure) -> ModeLine:
        tree, body = self._system.tree, self._system.tree.index[part.name]
        s = np.linspace(*part.ends, MODES_SAMPLES)
        along, across = part.modes.shapes(s)
        eta = int(tree.bodies.records[body]["eta"]) + np.arange(part.size)
        angle, still = self._pose[body, 2] + np.arctan2(*part.direction[::-1]), self._system.assembly.q[eta]
        arms = _turned(angle, np.column_stack([s + along @ still, across @ still]))
        own = np.stack([self._changes[eta].T @ along.T, self._changes[eta].T @ across.T], axis=-1)
        return ModeLine(link, color, self._pose[body, :2] + arms, self._displaced(body, arms) + _turned(angle, own))

    def _displaced(self, body: int, arms: Array) -> Array:
        """Displacements (m, n, 2) of points fixed to a body's frame at arms (n, 2) from its origin."""
        turn, x, y = (self._moved[:, body, k, None] for k in range(3))
        return np.stack([x - turn * arms[:, 1], y + turn * arms[:, 0]], axis=-1)


def _turned(angle: float, vectors: Array) -> Array:
    """Rotate vectors (..., 2) by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vectors[..., 0] - s * vectors[..., 1], s * vectors[..., 0] + c * vectors[..., 1]], axis=-1)
