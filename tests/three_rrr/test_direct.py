"""Every assembly, against independent formulations; the polynomial's form and its exact root count."""

from __future__ import annotations

import numpy as np
import pytest

from linkages.base.errors import InputError, Status
from linkages.three_rrr.branch import BranchError, start_assembly
from linkages.three_rrr.direct import assemblies, count, count_roots, polynomial
from linkages.three_rrr.geometry import Geometry
from linkages.three_rrr.kinematics import unit


def symmetric(a, b, l1, l2):
    """Build the paper's robot: equilateral triangles of sides a, b [m] centred on the origins, equal legs.

    A_1 A_2 and C_1 C_2 are parallel to x (x'); both triangles are counter-clockwise.
    """
    corners = np.array([[-0.5, -0.5 / np.sqrt(3.0)], [0.5, -0.5 / np.sqrt(3.0)], [0.0, 1.0 / np.sqrt(3.0)]])
    return Geometry(a * corners, b * corners, np.full(3, l1), np.full(3, l2))


PAPER = symmetric(0.6, 0.36, 0.112, 0.422)


def multi_start(geometry: Geometry, phi: np.ndarray) -> np.ndarray:
    """Platform poses from Newton's method on the six coordinates of C_1, C_2, C_3, from many starts.

    Unknowns and equations differ from the package's: squared coupler lengths and squared platform sides;
    mirror images of the platform are thrown out. Starts: every intersection of the circles of legs 1 and 2
    carried along a grid of platform angles.
    """
    b = geometry.base + geometry.crank[:, None] * unit(phi)
    local, length = geometry.platform, geometry.coupler
    theta = np.deg2rad(np.arange(0.0, 360.0, 3.0))
    turn = np.stack([np.stack([np.cos(theta), -np.sin(theta)], -1), np.stack([np.sin(theta), np.cos(theta)], -1)], 1)
    arms = np.einsum("nij,kj->nki", turn, local)
    starts = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        first, second = b[i] - arms[:, i], b[j] - arms[:, j]
        gap = second - first
        d = np.linalg.norm(gap, axis=1)
        along = (d**2 + length[i] ** 2 - length[j] ** 2) / (2 * d)
        height = np.sqrt(np.maximum(length[i] ** 2 - along**2, 0.0))
        e = gap / d[:, None]
        for side in (1.0, -1.0):
            normal = side * np.stack([-e[:, 1], e[:, 0]], -1)
            p = first + along[:, None] * e + height[:, None] * normal
            starts.append(p[:, None] + arms)
    c = np.concatenate(starts)
    sides = [(0, 1), (1, 2), (2, 0)]
    wanted = np.array([np.sum((local[i] - local[j]) ** 2) for i, j in sides])
    best = np.full(len(c), np.inf)
    kept = c.copy()
    for _ in range(40):
        f = np.concatenate(
            [
                np.sum((c - b) ** 2, -1) - length**2,
                np.stack([np.sum((c[:, i] - c[:, j]) ** 2, -1) for i, j in sides], 1) - wanted,
            ],
            axis=1,
        )
        size = np.max(np.abs(f), axis=1)
        kept[size < best] = c[size < best]
        best = np.minimum(best, size)
        jac = np.zeros((len(c), 6, 6))
        for r in range(3):
            jac[:, r, 2 * r : 2 * r + 2] = 2 * (c[:, r] - b[r])
        for row, (i, j) in enumerate(sides):
            jac[:, 3 + row, 2 * i : 2 * i + 2] = 2 * (c[:, i] - c[:, j])
            jac[:, 3 + row, 2 * j : 2 * j + 2] = -2 * (c[:, i] - c[:, j])
        step = np.linalg.solve(jac + 1e-14 * np.eye(6), f[..., None]).reshape(-1, 3, 2)
        norm = np.linalg.norm(step.reshape(-1, 6), axis=1)
        c = c - step * np.minimum(1.0, 0.3 * geometry.size / np.maximum(norm, 1e-300))[:, None, None]
    kept = kept[best < 1e-14 * geometry.size**2]
    u, v = kept[:, 1] - kept[:, 0], kept[:, 2] - kept[:, 0]
    kept = kept[np.sign(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) == np.sign(geometry.platform_area)]
    found: list[np.ndarray] = []
    for pivots in kept:
        u, w = pivots[1] - pivots[0], local[1] - local[0]
        angle = np.arctan2(w[0] * u[1] - w[1] * u[0], w @ u)
        turn_one = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        x = np.array([angle, *(pivots[0] - turn_one @ local[0])])
        if not any(np.abs(np.angle(np.exp(1j * (x[0] - y[0])))) + np.max(np.abs(x[1:] - y[1:])) < 1e-6 for y in found):
            found.append(x)
    return np.array(sorted(found, key=lambda x: -x[0])).reshape(-1, 3)


def compare(geometry: Geometry, phi: np.ndarray) -> int:
    ours, theirs = assemblies(geometry, phi), multi_start(geometry, phi)
    assert len(ours) == len(theirs)
    assert ours.certified
    assert ours.error <= 1e-12
    np.testing.assert_allclose(ours.x, theirs, atol=1e-7)
    return len(ours)


@pytest.mark.slow
def test_all_assemblies_of_random_geometries() -> None:
    rng = np.random.default_rng(20100641)
    numbers = [
        compare(
            Geometry(
                rng.normal(size=(3, 2)) * 0.4,
                rng.normal(size=(3, 2)) * 0.3,
                rng.uniform(0.05, 0.5, 3),
                rng.uniform(0.2, 0.8, 3),
            ),
            rng.uniform(-np.pi, np.pi, 3),
        )
        for _ in range(100)
    ]
    assert {0, 2, 4, 6} == set(numbers)  # the sample has every number that there can be


@pytest.mark.slow
def test_all_assemblies_of_the_paper_at_random_angles() -> None:
    rng = np.random.default_rng(6)
    numbers = {compare(PAPER, rng.uniform(-np.pi, np.pi, 3)) for _ in range(60)}
    assert {2, 4} <= numbers


def test_paper_at_the_start() -> None:
    found = assemblies(PAPER, np.deg2rad([60.0, 0.0, 220.0]))
    np.testing.assert_allclose(np.rad2deg(found.x[:, 0]), [98.05, -87.51], atol=0.005)


def test_elimination_with_the_papers_coefficients_has_degree_three() -> None:
    """The paper's a_j, b_j, c_j (theta + 60 deg, A_3 for j = 3) give our polynomial, no powers above z^3."""
    a, b, l1, l2 = 0.6, 0.36, 0.112, 0.422
    phi = np.array([0.3, 1.9, -2.2])
    theta = 2 * np.pi * np.arange(64) / 64
    cos, sin = np.cos, np.sin

    def row(turn: float, at: float, drive: float) -> tuple[np.ndarray, ...]:
        """Difference of loops j and 1, origin A_1, (x, y) = C_1; A_j at distance a and angle `at`."""
        ax, ay, t = a * cos(at), a * sin(at), theta + turn
        bx, by = ax + l1 * cos(drive) - l1 * cos(phi[0]), ay + l1 * sin(drive) - l1 * sin(phi[0])
        ox, oy = ax + l1 * cos(drive), ay + l1 * sin(drive)
        c = b**2 - 2 * b * (ox * cos(t) + oy * sin(t)) + ox**2 + oy**2 - l1**2
        return 2 * b * cos(t) - 2 * bx, 2 * b * sin(t) - 2 * by, c

    a2, b2, c2 = row(0.0, 0.0, phi[1])
    printed = b**2 - 2 * a * b * cos(theta) - 2 * b * l1 * cos(phi[1] - theta) + a**2 + 2 * a * l1 * cos(phi[1])
    np.testing.assert_allclose(c2, printed, atol=1e-15)
    a3, b3, c3 = row(np.pi / 3, np.pi / 3, phi[2])
    det = a2 * b3 - a3 * b2
    x, y = -(c2 * b3 - c3 * b2), -(a2 * c3 - a3 * c2)
    f = (x - det * l1 * cos(phi[0])) ** 2 + (y - det * l1 * sin(phi[0])) ** 2 - (l2 * det) ** 2
    spectrum = np.fft.fft(f) / 64
    assert np.max(np.abs(spectrum[4:61])) < 1e-14 * np.max(np.abs(spectrum))
    ours = polynomial(PAPER, phi[None])[0]
    theirs = spectrum[[-3, -2, -1, 0, 1, 2, 3]]
    ratio = ours[3].real / theirs[3].real
    np.testing.assert_allclose(ours, ratio * theirs, atol=1e-13)


@pytest.mark.parametrize(
    ("powers", "roots"),
    [
        ({3: 0.5}, 6),  # cos 3 theta
        ({0: 1.0, 1: 0.25}, 0),  # 1 + cos(theta)/2
        ({0: -1.0, 1: 0.5}, 1),  # cos(theta) - 1: a double root counts once
        ({0: -0.999999, 1: 0.5}, 2),
        ({0: -1.000001, 1: 0.5}, 0),
        ({2: 0.5, 0: -0.3}, 4),
    ],
)
def test_exact_count_of_roots(powers: dict[int, float], roots: int) -> None:
    f = np.zeros(7, dtype=complex)
    for power, value in powers.items():
        f[3 + power] += value
        if power:
            f[3 - power] += value
    assert count_roots(f) == roots


@pytest.mark.parametrize("seed", range(12))
def test_two_assemblies_with_one_theta(seed: int) -> None:
    """Where the three circles' centres are in line the platform has two positions at the same angle."""
    rng = np.random.default_rng(seed)
    phi = rng.uniform(-np.pi, np.pi, 3)
    platform = np.array([[-0.15, -0.1], [0.2, -0.08], [0.02, 0.2]])
    centres = rng.uniform(-0.2, 0.2, (3, 1)) * unit(rng.uniform(0.0, np.pi))
    crank = np.array([0.1, 0.12, 0.14])
    place = np.array([0.03, 0.3])
    geometry = Geometry(
        centres + platform - crank[:, None] * unit(phi), platform, crank, np.linalg.norm(place - centres, axis=1)
    )
    line = (centres[1] - centres[0]) / np.linalg.norm(centres[1] - centres[0])
    mirrored = 2.0 * (place @ line) * line - place
    found = assemblies(geometry, phi)
    for want in (place, mirrored):
        assert np.min(np.max(np.abs(found.x - [0.0, *want]), axis=1)) < 1e-7
    assert len(found) == len(multi_start(geometry, phi))


def test_vectorised_count_agrees() -> None:
    phi = np.random.default_rng(3).uniform(-np.pi, np.pi, (100, 3))
    assert count(PAPER, phi).tolist() == [len(assemblies(PAPER, row)) for row in phi]


def test_no_assembly_is_a_status() -> None:
    far = symmetric(3.0, 0.36, 0.112, 0.422)
    with pytest.raises(BranchError, match="no assembly at the crank angles 60, 0, 220 deg") as caught:
        start_assembly(far, np.deg2rad([60.0, 0.0, 220.0]))
    assert caught.value.status is Status.NO_ASSEMBLY


@pytest.mark.parametrize("sizes", [(0.6, 0.36, 0.0, 0.422), (0.6, 0.36, 0.112, -0.1), (0.6, 0.0, 0.112, 0.422)])
def test_lengths_must_be_positive(sizes: tuple[float, ...]) -> None:
    with pytest.raises(InputError):
        symmetric(*sizes)
