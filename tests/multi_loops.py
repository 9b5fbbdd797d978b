"""Linkages with several loops, and their kinematics and energy in natural coordinates: no kernel of the package.

The unknowns are the plane coordinates of the points. A link keeps the distance of its first two points; each further point
is a fixed combination of them. A slider keeps its point on a line of the ground, or of a link. Newton's method follows
the points from the reference configuration.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass

import numpy as np
from documented_machines import documented


def _machine(title: str, links: str, points: str, drive: str = "O") -> str:
    return f"""title = "{title}"
duration = "1 s"
outputs = []
drives = {{ {drive} = {{ speed = "60 r/min" }} }}
section = ["20 mm", "8 mm"]
density = "7850 kg/m3"
[links]
{links}
[points]
{points}
"""


_STEPHENSON_3 = (
    """ground = "O D F"
crank = "O A"
coupler = "A B C"
rocker = "D B"
rod = "C E"
output = "F E"
""",
    """O = [0, 0]
D = ["200 mm", 0]
F = ["300 mm", "-80 mm"]
A = ["O", "60 mm", "60 deg"]
B = ["A", "190 mm", "D", "130 mm"]
C = ["A", "140 mm", "B", "90 mm"]
E = ["C", "220 mm", "F", "170 mm"]""",
)

#: Descriptions by name. The first four mechanisms are in the documentation.
MACHINES = {
    "whitworth": documented("Quick return"),
    "stephenson 3": documented("Six-bar"),
    "toggle press": re.sub("forces .*\n", "", documented("Toggle")),
    "jansen": documented("Leg"),
    "stephenson 3 driven at the output": _machine("Six-bar with a triad", *_STEPHENSON_3, drive="F"),
    "stephenson 1": _machine(
        "Six-bar of Stephenson's first kind",
        'ground = "O Q"\ncrank = "O A C"\ncoupler = "A B"\nrocker = "Q B D"\nfirst = "C E"\nsecond = "D E"',
        'O = [0, 0]\nQ = [0.3, 0]\nA = ["O", 0.1, "50 deg"]\nB = ["A", 0.28, "Q", 0.2]\nC = ["O", 0.07, "110 deg"]\n'
        'D = ["Q", 0.15, "70 deg"]\nE = ["C", 0.25, "D", 0.22]',
    ),
    "watt 1": _machine(
        "Six-bar of Watt's first kind",
        'ground = "O Q"\ncrank = "O A"\ncoupler = "A B C"\nrocker = "Q B D"\nfirst = "C E"\nsecond = "D E"',
        'O = [0, 0]\nQ = [0.3, 0]\nA = ["O", 0.08, "50 deg"]\nB = ["A", 0.26, "Q", 0.2]\nC = ["A", 0.3, "B", 0.12]\n'
        'D = ["B", 0.14, "Q", 0.26]\nE = ["D", 0.2, "C", 0.22]',
    ),
    "watt 2": _machine(
        "Six-bar of Watt's second kind",
        'ground = "O Q P"\ncrank = "O A"\ncoupler = "A B"\nrocker = "Q B C"\nrod = "C D"\noutput = "P D"',
        'O = [0, 0]\nQ = [0.3, 0]\nP = [0.6, 0.02]\nA = ["O", 0.08, "50 deg"]\nB = ["A", 0.26, "Q", 0.2]\n'
        'C = ["Q", 0.18, "60 deg"]\nD = ["C", 0.28, "P", 0.2]',
    ),
    "peaucellier": _machine(
        "Cell of Peaucellier",
        'ground = "O Q"\ncrank = "Q C"\nupper = "O A"\nlower = "O B"\nca = "C A"\ncb = "C B"\nad = "A D"\nbd = "B D"',
        'O = [0, 0]\nQ = [0.1, 0]\nC = ["Q", 0.1, "20 deg"]\nA = ["O", 0.3, "C", 0.15]\nB = ["C", 0.15, "O", 0.3]\n'
        'D = ["B", 0.15, "A", 0.15]',
        drive="Q",
    ),
    "hart": _machine(
        "Inversor of Hart",
        'ground = "O Q"\ncrank = "Q P"\nfixed = "A O B"\nlong = "A P D"\nacross = "B C"\nshort = "C D"',
        'O = [0, 0]\nA = [-0.06, 0.0]\nB = [0.06, 0.0]\nD = ["A", 0.3, "40 deg"]\nP = ["A", 0.15, "D"]\n'
        'C = ["D", 0.12, "B", 0.3]\nQ = ["P", 0.16, "O", 0.2]',
        drive="Q",
    ),
    "atkinson": _machine(
        "Engine of Atkinson",
        'ground = "O D"\ncrank = "O A"\nlink = "A B C"\nrocker = "D B"\nrod = "C E"\npiston = "E along ground"',
        'O = [0, 0]\nD = ["-60 mm", "-180 mm"]\nA = ["O", "60 mm", "40 deg"]\nB = ["D", "150 mm", "A", "190 mm"]\n'
        'C = ["A", "220 mm", "B", "50 mm"]\nE = ["C.x - sqrt((300 mm)**2 - C.y**2)", 0]',
    ),
    "eight-bar": _machine(
        "Eight-bar without dyads",
        'ground = "O G H"\ncrank = "O A"\none = "A B C"\ntwo = "D E F"\nthree = "B D K"\nfour = "C E"\nleft = "G K"\nright = "H F"',
        'O = [0, 0]\nG = [-0.15, 0.3]\nH = [0.55, 0.1]\nA = ["O", 0.04, "40 deg"]\nB = [0.0, 0.2]\nC = [0.16, 0.16]\n'
        "D = [0.05, 0.4]\nE = [0.25, 0.38]\nF = [0.3, 0.2]\nK = [-0.05, 0.32]",
    ),
}

#: Lines of force of each dyad by its pin: pairs of points, or the normal of a slide.
LINES = {
    "whitworth": {"E": (("B", "E"), 1j)},
    "stephenson 3": {"B": (("A", "B"), ("D", "B")), "E": (("C", "E"), ("F", "E"))},
    "toggle press": {"B": (("A", "B"), ("D", "B")), "E": (("B", "E"), 1.0)},
    "jansen": {"C": (("A", "C"), ("B", "C")), "E": (("A", "E"), ("B", "E")), "F": (("D", "F"), ("E", "F"))},
    "stephenson 3 driven at the output": {},
    "stephenson 1": {"B": (("A", "B"), ("Q", "B")), "E": (("C", "E"), ("D", "E"))},
    "watt 1": {"B": (("A", "B"), ("Q", "B")), "E": (("C", "E"), ("D", "E"))},
    "watt 2": {"B": (("A", "B"), ("Q", "B")), "D": (("C", "D"), ("P", "D"))},
    "peaucellier": {"A": (("C", "A"), ("O", "A")), "B": (("C", "B"), ("O", "B")), "D": (("A", "D"), ("B", "D"))},
    "hart": {"A": (("P", "A"), ("O", "A")), "C": (("B", "C"), ("D", "C"))},
    "atkinson": {"B": (("A", "B"), ("D", "B")), "E": (("C", "E"), 1j)},
    "eight-bar": {},
}


@dataclass
class Model:
    """A machine in natural coordinates; points are complex numbers."""

    drawn: dict[str, complex]
    free: list[str]
    links: dict[str, list[str]]
    slides: list[tuple[str, str, complex]]  # point, link on which it slides or "ground", direction on the ground
    pivot: str
    tip: str
    masses: dict[str, tuple[float, float, complex]]  # mass, inertia, drawn mass centre

    def __post_init__(self):
        self.points, self.angle = dict(self.drawn), 0.0

    def equations(self, points, driven=None):
        """Residuals of all links and slides, and of the drive at an angle from the reference configuration."""
        out = []
        for names in self.links.values():
            start, end = (points[name] for name in names[:2])
            first, second = (self.drawn[name] for name in names[:2])
            out.append(abs(end - start) ** 2 - abs(second - first) ** 2)
            for name in names[2:]:
                gap = points[name] - start - (self.drawn[name] - first) / (second - first) * (end - start)
                out += [gap.real, gap.imag]
        for name, link, direction in self.slides:
            base, along = self.drawn[name], direction
            if link != "ground":
                base, along = points[self.links[link][0]], points[self.links[link][1]] - points[self.links[link][0]]
            out.append(((points[name] - base) * np.conj(along) / abs(along)).imag)
        if driven is not None:
            arm = (self.drawn[self.tip] - self.drawn[self.pivot]) * np.exp(1j * driven)
            gap = points[self.tip] - points[self.pivot] - arm
            out += [gap.real, gap.imag]
        return np.array(out)

    def jacobian(self, points, driven=None):
        """Derivatives of `equations` to the coordinates of the free points, by central differences (quadratic: exact)."""
        columns = []
        for name in self.free:
            for step in (1e-4, 1e-4j):
                high, low = ({**points, name: points[name] + sign * step} for sign in (1, -1))
                columns.append((self.equations(high, driven) - self.equations(low, driven)) / 2e-4)
        return np.stack(columns, axis=1)

    def mobility(self):
        """Degrees of freedom in the reference configuration: coordinates minus independent equations."""
        jacobian = self.jacobian(self.drawn)
        return jacobian.shape[1] - np.linalg.matrix_rank(jacobian, tol=1e-7)

    def close(self, angle):
        """Move the points to a drive angle from the reference configuration; False if that fails."""
        points = dict(self.points)
        for _ in range(30):
            gap = self.equations(points, angle)
            if np.abs(gap).max() < 1e-14:
                break
            step = np.linalg.lstsq(self.jacobian(points, angle), -gap, rcond=None)[0]
            if np.abs(step).max() > 0.05:  # m: to another branch
                return False
            for name, dx, dy in zip(self.free, step[::2], step[1::2], strict=True):
                points[name] += complex(dx, dy)
        if np.abs(self.equations(points, angle)).max() > 1e-12:
            return False
        self.points = points
        return True

    def go_to(self, angle):
        """Move in small steps from the reference configuration."""
        self.points, self.angle = dict(self.drawn), 0.0
        self.go_on(angle)

    def go_on(self, angle):
        """Move in small steps from the present angle."""
        for between in np.linspace(self.angle, angle, 2 + int(abs(angle - self.angle) / 0.01))[1:]:
            assert self.close(between), between
        self.angle = angle

    def at_each(self, angles):
        """Points at angles, the first of them near the present one."""
        found = []
        for angle in angles:
            self.go_on(angle)
            found.append(dict(self.points))
        return {name: np.array([points[name] for points in found]) for name in self.drawn}

    def rate(self, point, angle):
        """Derivative of a point to the angle of the drive, near the present angle."""
        self.go_on(angle)
        return self.rates(self.points, angle)[point]

    def farthest(self, way):
        """Angle in steps of this sign at which the loops cannot be closed any more, at most one turn."""
        self.points, angle = dict(self.drawn), 0.0
        step = 0.01 * np.sign(way)
        while abs(step) > 1e-12 and abs(angle) < 2.0 * np.pi:
            if self.close(angle + step):
                angle += step
            else:
                step *= 0.5
        return angle

    def rates(self, points, angle):
        """Derivatives of the points to the angle of the drive."""
        arm = 1j * (points[self.tip] - points[self.pivot])
        rhs = np.zeros(len(self.equations(points, angle)))
        rhs[-2:] = arm.real, arm.imag
        found = np.linalg.lstsq(self.jacobian(points, angle), rhs, rcond=None)[0]
        rates = dict.fromkeys(self.drawn, 0j)
        return rates | {n: complex(x, y) for n, x, y in zip(self.free, found[::2], found[1::2], strict=True)}

    def energy(self, angle, speed, gravity):
        """Kinetic and potential energy [J] at an angle close to the present one and a speed of the drive [rad/s]."""
        assert self.close(angle)
        points, total = self.points, 0.0
        rates = self.rates(points, angle)
        turning = {}
        for link, names in self.links.items():
            arm = points[names[1]] - points[names[0]]
            turning[link] = ((rates[names[1]] - rates[names[0]]) * np.conj(arm)).imag / abs(arm) ** 2
        guided = {name: link for name, link, _ in self.slides}
        for link, (mass, inertia, centre) in self.masses.items():
            name = self.links[link][0] if link in self.links else self.sliders[link]
            omega = turning.get(link, turning.get(guided.get(name, ""), 0.0))
            if link in self.links:
                names = self.links[link]
                turn = (points[names[1]] - points[names[0]]) / (self.drawn[names[1]] - self.drawn[names[0]])
            else:
                turn = 1.0
                assert abs(centre - self.drawn[name]) < 1e-12  # a block is centred on its pin
            arm = turn * (centre - self.drawn[name])
            velocity = rates[name] + 1j * omega * arm
            total += 0.5 * speed**2 * (mass * abs(velocity) ** 2 + inertia * omega**2)
            total += mass * gravity * (points[name] + arm).imag
        return total

    def torque(self, angle, speed, gravity):
        """Torque of the drive at a constant speed: the derivative of the energy to its angle."""
        h = 2e-4
        self.go_to(angle)
        values = [self.energy(angle + k * h, speed, gravity) for k in (-2, -1, 1, 2)]
        return (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h)


def natural(text: str, mechanism) -> Model:
    """Make the model of a description; points and masses come from the mechanism's file."""
    given = tomllib.loads(text)
    links, slides, sliders = {}, [], {}
    for link, points in given["links"].items():
        if " along " in points:
            name, _, on = re.match(r"(\w+) (along) (\w+)", points).groups()
            turned = re.search(r"at ([\d.]+) deg", points)
            slides.append((name, on, np.exp(1j * np.radians(float(turned[1]) if turned else 0.0))))
            sliders[link] = name
        else:
            links[link] = re.findall(r"\w+", points)
    ground = links.pop("ground")
    drawn = {name: complex(*mechanism.joint[name].on_parent) for name in given["points"] if name in mechanism.joint}
    links = {link: [name for name in names if name in drawn] for link, names in links.items()}
    (pivot,) = given["drives"]
    tip = next(
        name for names in links.values() if pivot in names and pivot in ground for name in names if name != pivot
    )
    masses = {one.name: (one.mass, one.inertia, complex(*one.com)) for one in mechanism.links}
    found = Model(drawn, [n for n in drawn if n not in ground], links, slides, pivot, tip, masses)
    found.sliders = sliders
    return found
