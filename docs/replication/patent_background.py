"""Statements of the patent on clearance and older remedies: paragraphs [0003], [0004] and [0057], in numbers.

The four-bar of the example runs for `REVOLUTIONS` from `STARTS` start angles at several speeds, and at 600 r/min with several remedies.
Of each setting the medians over start angles and revolutions after the first two are kept: of the largest force in the joint, of the
largest departure of the follower's acceleration from the ideal linkage's, of the number of contacts, and of the share of time in contact.
``python docs/make_patent.py`` computes them.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from linkages import System, extremes, find_file, ideal, impacts, load, simulate
from replication.computed import read
from replication.verdicts import Claim, parts

#: Name of the file of results, and the command that writes it.
FILE, COMMAND = "patent_background", "python docs/make_patent.py"
RPM = np.pi / 30.0  # rad/s
SPEEDS = (150.0, 300.0, 600.0, 900.0)  # r/min
CLEARANCES = (0.1e-3, 0.25e-3)  # m, beside the example's 0.5 mm
EXAMPLE = "600 r/min"
ROD = "massless rod"
STARTS, REVOLUTIONS, SKIPPED = 4, 8, 2
_LENGTH, _MASS = 0.5e-3, 1e-5  # m, kg, of the rod: less than a ten-thousandth of the bars' mass
_FAR = 10.0  # m: a spring so long pulls with an almost constant force
_OUTPUT = "follower.alpha"


class Setting(NamedTuple):
    """Medians over start angles and revolutions; `ideal_force` and `ideal_acceleration` without clearance.

    Forces [N], departure and acceleration [rad/s2], contacts per revolution, share of time in contact.
    """

    force: float
    departure: float
    contacts: float
    touching: float
    ideal_force: float
    ideal_acceleration: float


def pulled(force: float) -> dict[str, Any]:
    """Give overrides that pull the follower's pin along x by an almost constant force [N]."""
    spring = {"point": "follower_B", "anchor": [_FAR, 0.0], "stiffness": force / _FAR, "free_length": 0.0}
    return {"springs.pull": spring}


def film(viscosity: float) -> dict[str, Any]:
    """Give overrides that fill the joint with oil [Pa s]."""
    return {
        "joints.B": {
            "model": "lubricated", "clearance": 0.5e-3, "film": "finite", "viscosity": viscosity,
        }
    }  # fmt: skip


def weighted(follower: float, coupler: float) -> dict[str, Any]:
    """Give overrides that multiply the masses of follower and coupler, with their moments of inertia."""
    value = load(find_file("four_bar_dry.toml")).value
    return {
        f"sdf.links.{link}.{key}": part * value(f"sdf.links.{link}.{key}")
        for link, part in (("follower", follower), ("coupler", coupler))
        for key in ("mass", "inertia")
    }


def settings() -> dict[str, Callable[[float], System]]:
    """Give the system of each setting by name, from a start angle [rad]."""
    speeds = {f"{rpm:g} r/min": {"drives.O.speed": rpm * RPM, "drives.O.ramp": 12.0 / rpm} for rpm in SPEEDS}
    clearances = {f"{1e3 * c:g} mm": {"joints.B.clearance": c} for c in CLEARANCES}
    oils = {f"oil of {mu:g} Pa s": film(mu) for mu in (0.1, 0.4)}
    springs = {f"spring of {force:g} N": pulled(force) for force in (1000.0, 3000.0)}
    masses = {
        "follower twice as heavy": weighted(2.0, 1.0), "follower half as heavy": weighted(0.5, 1.0),
        "coupler twice as heavy": weighted(1.0, 2.0), "coupler half as heavy": weighted(1.0, 0.5),
    }  # fmt: skip
    centres = {
        "mass centre of the follower at Q": {"sdf.links.follower.com.x": 0.0},
        "mass centre of the coupler at A": {"sdf.links.coupler.com.x": 0.0},
        "mass centres of both at Q and A": {"sdf.links.follower.com.x": 0.0, "sdf.links.coupler.com.x": 0.0},
    }
    found: dict[str, dict[str, Any]] = speeds | clearances | oils | springs | masses | centres
    return {name: partial(_started, overrides) for name, overrides in found.items()} | {ROD: _rod}


def _started(overrides: Mapping[str, Any], angle: float) -> System:
    system = load(find_file("four_bar_dry.toml"), dict(overrides) | {"drives.O.angle": angle, "outputs": [_OUTPUT]})
    return system.replaced({"duration": REVOLUTIONS * _period(system)})


def _rod(angle: float) -> System:
    """Put a rod of almost no mass, as long as the clearance, in place of the clearance joint."""
    plain = find_file("four_bar_dry.toml")
    text = (plain.parent / "four_bar.sdf").read_text(encoding="utf-8")
    before, joint, after = text.partition('<joint name="B"')
    rod = (
        '<link name="rod"><pose relative_to="coupler_B">0 0 0 0 0 0</pose>'
        f"<inertial><pose>{0.5 * _LENGTH} 0 0 0 0 0</pose><mass>{_MASS}</mass><inertia><ixx>1e-12</ixx>"
        f"<iyy>{_MASS * _LENGTH**2}</iyy><izz>{_MASS * _LENGTH**2}</izz></inertia></inertial></link>"
        f'<frame name="rod_B" attached_to="rod"><pose>{_LENGTH} 0 0 0 0 0</pose></frame>'
        '<joint name="R" type="revolute"><parent>coupler_B</parent><child>rod</child><axis><xyz>0 0 1</xyz></axis></joint>'
    )
    with tempfile.TemporaryDirectory() as folder:
        machine = Path(folder) / "rod.sdf"
        machine.write_text(
            before + rod + joint + after.replace("<parent>coupler_B<", "<parent>rod_B<", 1), encoding="utf-8"
        )
        experiment = Path(folder) / "rod.toml"
        experiment.write_text(
            f'mechanism = "rod.sdf"\nduration = {REVOLUTIONS * 0.1}\ngravity = [0.0, 0.0, 0.0]\noutputs = ["{_OUTPUT}"]\n'
            f"[drives.O]\nspeed = {600.0 * RPM}\nramp = 0.02\nangle = {angle}\n", encoding="utf-8",
        )  # fmt: skip
        return load(experiment)


def _period(system: System) -> float:
    speed = system.experiment.drives["O"].speed
    assert speed is not None  # the example's crank turns at a constant speed
    return 2.0 * np.pi / speed


def compute(system_of: Callable[[float], System]) -> Setting:
    """Run a setting from all start angles; the ideal linkage is that of the example where the setting has none."""
    rows = []
    for k in range(STARTS):
        system = system_of(2.0 * np.pi * k / STARTS)
        joints = system.experiment.joints
        period = _period(system)
        run = simulate(system, "compiled")
        perfect = ideal(system if joints else _started({}, 2.0 * np.pi * k / STARTS), "compiled")
        touched = impacts(run, ["B"]) if joints and joints["B"].model == "dry" else []
        for n in range(SKIPPED, REVOLUTIONS):
            start, end = n * period, (n + 1) * period
            times = np.linspace(start, end, 20001)
            apart = np.abs(run.evaluate(times)[_OUTPUT] - perfect.evaluate(times)[_OUTPUT]).max()
            inside = [one for one in touched if start <= one.start < end]
            share = sum(one.duration for one in inside if np.isfinite(one.duration)) / period
            real, exact = (extremes(one.within(start, end), ["B.force", _OUTPUT]) for one in (run, perfect))
            rows.append((real["B.force"].peak, apart, len(inside), share, exact["B.force"].peak, exact[_OUTPUT].peak))
    return Setting(*(float(f"{value:.4g}") for value in np.median(rows, axis=0)))


def known() -> dict[str, Setting]:
    """Read the stored settings."""
    return {name: Setting(**row) for name, row in read(FILE).items()}


def background() -> list[Claim]:
    """Paragraphs [0003], [0004] and [0057]."""
    found = known()
    fast = [found[f"{rpm:g} r/min"] for rpm in SPEEDS]
    example, rod = found[EXAMPLE], found[ROD]
    wide = [found["0.1 mm"], found["0.25 mm"], example]

    def listed(values: Sequence[float], form: str = ".3g") -> str:
        return ", ".join(format(value, form) for value in values)

    force = [one.force for one in fast]
    over = [one.force / one.ideal_force for one in fast]
    jitter = [one.departure for one in fast]
    relative = [one.departure / one.ideal_acceleration for one in fast]
    return [
        _claim(
            "clearance raises the joint's force, [0003]", f"{listed(over)} times the ideal force at {listed(SPEEDS, 'g')} r/min",
            [value > 1.0 for value in over], "largest force in a revolution",
        ),
        _claim(
            "clearance makes the acceleration shake, high and often, [0003]",
            f"largest departure {listed(relative)} times the ideal linkage's largest acceleration; {listed([one.contacts for one in fast], 'g')} contacts in a revolution",
            [value > 1.0 for value in relative] + [one.contacts > 1.0 for one in fast], "same speeds",
        ),
        _claim(
            "the effect is larger in fast machines, [0003]",
            f"force {listed(force)} N, departure {listed(jitter)} rad/s² at {listed(SPEEDS, 'g')} r/min",
            [a < b for series in (force, jitter) for a, b in pairwise(series)],
            "true in absolute terms; relative to the ideal linkage's values, which grow with the square of the speed, force and departure decrease",
        ),
        _claim(
            "a larger clearance shakes more, [0003]", f"departure {listed([one.departure for one in wide])} rad/s² at 0.1, 0.25, 0.5 mm",
            [a.departure < b.departure for a, b in pairwise(wide)], "600 r/min",
        ),
        *_remedies(found),
        _claim(
            "clearance changes the topology: free flight and contact in turn, [0057]",
            f"{example.contacts:g} contacts in a revolution, in contact during {100.0 * example.touching:.0f} % of the time",
            [example.contacts > 1.0, 0.0 < example.touching < 1.0], "each start and end of a contact is located in time, as the patent's dynamic segmentation does",
        ),
        _claim(
            "a massless rod instead of the clearance misses the contact, [0004]",
            f"rod of 0.5 mm and 10 mg: force {listed([rod.force])} N, departure {listed([rod.departure])} rad/s²; contact {listed([example.force])} N"
            f" and {listed([example.departure])} rad/s²",
            [abs(np.log(a / b)) > np.log(2.0) for a, b in ((rod.force, example.force), (rod.departure, example.departure))],
            "true if either differs by more than a factor of 2: the rod reverses instantly, without the elasticity of the bodies",
        ),
    ]  # fmt: skip


#: More settings than this are told by their range.
_LISTED = 3


def _remedies(found: Mapping[str, Setting]) -> list[Claim]:
    """Compare the older remedies of [0004] with the dry joint."""
    dry = found[EXAMPLE]

    def row(title: str, names: list[str], why: str) -> Claim:
        told = "; ".join(
            f"{name}: departure {100.0 * (found[name].departure / dry.departure - 1.0):+.0f} %, force"
            f" {100.0 * (found[name].force / dry.force - 1.0):+.0f} %, contacts {dry.contacts:g} -> {found[name].contacts:g}"
            for name in names
        )
        held = [found[name].departure < dry.departure for name in names]
        if len(names) <= _LISTED:
            return _claim(title, told, held, why)
        departures, forces = (
            [100.0 * (getattr(found[name], key) / getattr(dry, key) - 1.0) for name in names]
            for key in ("departure", "force")
        )
        short = (
            f"{len(names)} changes: departure {min(departures):+.0f} to {max(departures):+.0f} %,"
            f" force {min(forces):+.0f} to {max(forces):+.0f} %"
        )
        return _claim(title, short, held, f"{why}; {told}")

    listed = list(found)
    return [
        row("oil in the clearance is a remedy, [0004]", [n for n in listed if n.startswith("oil")], "finite film, guembel; viscosities assumed"),
        row(
            "a constant spring force is a remedy, [0004]", [n for n in listed if n.startswith("spring")],
            "along the ground at the follower's pin, more than the largest ideal force; magnitudes assumed",
        ),
        row(
            "masses redistributed are a remedy, [0004]", [n for n in listed if n.endswith("heavy") or n.startswith("mass centre")],
            "mass and moment of inertia, or mass centre, of a bar; values assumed",
        ),
    ]  # fmt: skip


def _claim(title: str, ours: str, held: list[bool], why: str) -> Claim:
    return Claim(title, "none", ours, [parts(held)], why, stored=COMMAND)
