"""Drop test: a journal that falls in its bearing, the smallest mechanism; for self-checks and precompilation.

A centred journal under gravity g hits the wall after sqrt(2 c/g) with the speed sqrt(2 c g). Its largest penetration d
follows from the energy of an elastic contact of force K d^1.5: m g (c + d) = K d^2.5 / 2.5.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from linkages.system import System, load

GRAVITY, CLEARANCE, MASS, STIFFNESS = 9.81, 1e-3, 1.0, 1e9  # [m/s2, m, kg, N/m^1.5]

_SDF = f"""<sdf version="1.9" xmlns:linkages="urn:linkages:sdf"><model name="drop">
<link name="journal"><inertial><mass>{MASS}</mass>
<inertia><ixx>1e-4</ixx><iyy>1e-4</iyy><izz>1e-4</izz></inertia></inertial></link>
<joint name="J" type="revolute"><parent>world</parent><child>journal</child><axis><xyz>0 0 1</xyz></axis>
<linkages:bearing><linkages:radius>0.01</linkages:radius><linkages:length>0.02</linkages:length></linkages:bearing>
</joint></model></sdf>"""

_TOML = f"""mechanism = "drop.sdf"
duration = 0.0155
gravity = [0.0, {-GRAVITY}, 0.0]
[joints.J]
model = "dry"
clearance = {CLEARANCE}
contact = {{law = "lankarani-nikravesh", restitution = 1.0, stiffness = {STIFFNESS}}}
[solver]
accuracy = 1e-12
"""


def drop() -> System:
    """Make the system: a run of 15.5 ms, with fall, impact and rebound of the journal."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "drop.sdf").write_text(_SDF, encoding="utf-8")
        (Path(folder) / "drop.toml").write_text(_TOML, encoding="utf-8")
        return load(Path(folder) / "drop.toml")


def deepest() -> float:
    """Compute the depth at which the contact has absorbed the energy of the fall [m]."""
    depth = 0.0
    for _ in range(20):  # each iteration reduces the error forty times
        depth = (2.5 * MASS * GRAVITY * (CLEARANCE + depth) / STIFFNESS) ** 0.4
    return depth
