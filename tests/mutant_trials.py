"""Trials of mutants: each gives a mutant to the program, and checks how that ends.

A trial returns one word for the ending; an exception is a fault of the program.
"""

from __future__ import annotations

import io
import json
import shutil
import tempfile
import time
from contextlib import redirect_stderr, redirect_stdout
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
import toy_optimisation
from dialects import LOOPS, Style, urdf
from dialects import MACHINES as FOREIGN_MACHINES
from documented_machines import MACHINES as DOCUMENTED
from mutants import MACHINES, Mutator, write

import linkages
import optim
from linkages.base.errors import InputError, RunError
from linkages.cli.main import main

SILENT = 10.0  # s of the processor that a command may print nothing
OPEN = 1e-6  # of the linkage's size: a loop that is farther open was not closed

DESCRIPTIONS = list(DOCUMENTED.values())

#: Of another program, with a loop in it.
URDF = b"""<robot name="four_bar">
<link name="world"/>
<link name="crank"><inertial><origin xyz="0.05 0 0" rpy="0 0 0.1"/><mass value="0.2"/>
<inertia ixx="0" iyy="2e-4" izz="2e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="coupler"><inertial><origin xyz="0.125 0 0"/><mass value="0.2"/>
<inertia ixx="0" iyy="1e-3" izz="1e-3"/></inertial><visual><geometry><box size="0.2 0.01 0.01"/></geometry></visual></link>
<link name="follower"><inertial><mass value="0.2"/><inertia ixx="0" iyy="1e-3" izz="1e-3"/></inertial></link>
<joint name="O" type="continuous"><parent link="world"/><child link="crank"/><axis xyz="0 0 1"/></joint>
<joint name="A" type="continuous"><origin xyz="0.1 0 0" rpy="0 0 0.5"/><parent link="crank"/><child link="coupler"/>
<axis xyz="0 0 1"/></joint>
<joint name="Q" type="revolute"><origin xyz="0.3 0 0" rpy="0 0 1.2"/><parent link="world"/><child link="follower"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="0" velocity="0"/></joint>
<loop_joint name="B" type="continuous"><axis xyz="0 0 1"/><link1 link="coupler" xyz="0.25 0 0" rpy="0 0 0"/>
<link2 link="follower" xyz="0.2 0 0" rpy="0 0 0"/></loop_joint></robot>"""

#: With loops in all notations; a world with automatic inertia; gears, a spring, start positions.
FOREIGN = [urdf(FOREIGN_MACHINES["four_bar"], Style(loop=loop)).encode() for loop in LOOPS]
FOREIGN.append(b"""<sdf version="1.11"><world name="w"><gravity>0 0 -9</gravity><model name="ground"><static>1</static></model>
<include><uri>model://sun</uri></include><model name="m"><link name="arm"><inertial auto="true"><mass>2</mass></inertial>
<collision name="c"><pose>0.5 0 0 0 0 0</pose><density>1000</density><geometry><capsule><radius>.1</radius><length>1</length>
</capsule></geometry></collision></link><joint name="A" type="revolute"><parent>world</parent><child>arm</child><axis>
<xyz>0 1 0</xyz><initial_position>0.1</initial_position></axis></joint></model></world></sdf>""")
MORE = b"""<coupling name="c"><predecessor link="left"/><successor link="right"/><ratio value="2"/></coupling><gazebo reference="L">
<springStiffness>3</springStiffness><springReference>0.1</springReference></gazebo><ros2_control name="r"><joint name="R">
<param name="mimic">L</param><param name="multiplier">2</param><state_interface name="position"><param name="initial_value">0.2
</param></state_interface></joint></ros2_control><gazebo><plugin name="d" filename="detachable-joint"><parent_link>left
</parent_link><child_model>machine</child_model><child_link>right</child_link></plugin></gazebo></robot>"""
FOREIGN.append(urdf(FOREIGN_MACHINES["gripper"], Style()).encode().replace(b"</robot>", MORE))


class Told:
    """The outputs of a command, and the longest time of the processor without a line of either."""

    def __init__(self) -> None:
        self.silence, self._last = 0.0, time.process_time()

    def look(self) -> None:
        """Take note of a line, or of the end."""
        now = time.process_time()
        self.silence, self._last = max(self.silence, now - self._last), now


class Output(io.StringIO):
    """One of the outputs."""

    def __init__(self, told: Told) -> None:
        super().__init__()
        self._told = told

    def write(self, text: str) -> int:
        self._told.look()
        return super().write(text)


def command(*words: object) -> tuple[int, str, str]:
    """Run a command; return its exit status and the texts of both outputs."""
    told = Told()
    with redirect_stdout(Output(told)) as out, redirect_stderr(Output(told)) as errors:
        status = main([str(word) for word in words])
    told.look()
    if status == 130:
        raise KeyboardInterrupt(told.silence <= SILENT)
    assert told.silence <= SILENT, f"silent for {told.silence:.0f} s"
    assert status in (0, 1, 2), status
    lines = errors.getvalue().splitlines()
    refusals = [k for k, line in enumerate(lines, 1) if line.startswith("error: ")]
    assert refusals == ([len(lines)] if status == 2 else []), errors.getvalue()
    return status, out.getvalue(), errors.getvalue()


def load(mutator: Mutator, folder: Path) -> str:
    """Load a mutant: if it is accepted, its numbers are finite."""
    file, settings = write(mutator, folder, mutator.dice.choice(("machine", "experiment", "setting")))
    try:
        system = linkages.load(file, dict(item.split("=", 1) for item in settings))
        found = [
            system.gravity,
            *system.motions(np.zeros(1)),
            *(system.tree.bodies.records[x] for x in ("mass", "inertia")),
        ]
    except (InputError, RunError) as problem:
        return refusal(problem)
    assert all(np.isfinite(values).all() for values in found)
    return "taken"


def study(mutator: Mutator, folder: Path) -> str:
    """Load a mutant of a study: if it is accepted, its numbers are finite."""
    file, _ = write(mutator, folder, "study")
    try:
        found = optim.load_study(file)
    except (InputError, RunError) as problem:
        return refusal(problem)
    assert all(np.isfinite(x).all() for x in (found.lower, found.upper, found.nominal, *found.designs.values()))
    return "taken"


def refusal(problem: Exception) -> str:
    assert "\n" not in str(problem)
    return "refused"


@cache
def undamaged() -> bytes:
    """A store with a hundred evaluations."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.sqlite"
        toy_optimisation.run(toy_optimisation.make_task(generations=20), path)
        return path.read_bytes()


def store(mutator: Mutator, folder: Path) -> str:
    """Read a damaged store: it is rejected, or the content is unchanged."""
    path, table = folder / "study.sqlite", folder / "designs.csv"
    shown = []
    for data in (undamaged(), mutator.damage(undamaged())):
        path.write_bytes(data)
        table.unlink(missing_ok=True)
        status, told, _ = command("study", "show", path)
        exported, _, _ = command("study", "export", path, "--out", table)
        shown.append((told, table.read_bytes() if table.exists() else b""))
        assert status in (0, 2)
        assert status == exported, (status, exported)
    assert status == 2 or shown[0] == shown[1], "shows something else"
    return "taken" if status == 0 else "refused"


def importing(mutator: Mutator, folder: Path) -> str:
    """Import a mutant of another program's file: the written file loads with finite numbers."""
    source, out = folder / "theirs.xml", folder / "ours.sdf"
    out.unlink(missing_ok=True)
    given = [path.read_bytes() for path in MACHINES]
    source.write_bytes(
        mutator.mutant(mutator.dice.choice([mutator.dice.choice(given), URDF, mutator.dice.choice(FOREIGN)]))
    )
    status, _, _ = command("import", source, "--out", out)
    assert out.exists() == (status == 0)
    if status:
        return "refused"
    machine = linkages.load_mechanism(out)
    assert all(np.isfinite([link.mass, link.inertia, *link.com]).all() for link in machine.links)
    return "taken"


def describing(mutator: Mutator, folder: Path) -> str:
    """Draw a mutant of a mechanism's description, and run the result."""
    source, made = folder / "mutant.machine.toml", folder / "described"
    shutil.rmtree(made, ignore_errors=True)
    source.write_bytes(mutator.mutant(mutator.dice.choice(DESCRIPTIONS).encode()))
    status, _, _ = command("new", "--from", source, "--out", made)
    if status:
        assert not list(made.glob("*")), "something was written"
        return "refused"
    return ran(made / "mutant.toml", "compiled", folder)


def simulate(engine: str, mutator: Mutator, folder: Path) -> str:
    """Simulate a mutant."""
    file, settings = write(mutator, folder, mutator.dice.choice(("machine", "experiment", "setting")))
    return ran(file, engine, folder, settings)


def ran(file: Path, engine: str, folder: Path, settings: list[str] = []) -> str:  # noqa: B006
    """Run an experiment: the numbers of a run that is ok are finite, and its loops are closed."""
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    sets = [word for item in settings for word in ("--set", item)]
    how = ("--engine", engine, "--no-plots", "--no-animation", "--duration", "0.01", "--out", out)
    status, _, told = command("simulate", file, *how, *sets)
    if status == 2:
        assert not list(out.glob("*")), "something was written"
        return "refused"
    if not (out / "summary.json").exists():
        assert status == 1
        return "refused: no run"
    summary = json.loads((out / "summary.json").read_text(), parse_constant=lambda word: pytest.fail(word))
    assert (summary["status"] == "ok") == (status == 0) or "the run ended" not in told, summary["status"]
    if summary["status"] == "ok":
        assert None not in [output["peak"] for output in summary["outputs"].values()]
        run = linkages.load_trajectory(out / "trajectory.npz")
        assert all(np.isfinite(column).all() for column in run.columns.values())
        values = dict(item.split("=", 1) for item in settings) | {"duration": 0.01}
        system = linkages.load(file, values)
        gap, size = summary["mechanism"]["loop_error"], system.tree.extent
        assert gap <= OPEN * size, f"ok with a loop that is open by {gap:.1e} of {size:.1e} m"
    return summary["status"]


_LIFE = ("slider_crank_wear.toml", "--cycles", "200")


@cache
def results(kind: str) -> dict[str, bytes]:
    """Everything that a command writes, by path in its folder."""
    if kind == "wear":
        words = ("wear", *_LIFE)
    else:
        words = ("simulate", "slider_crank_dry.toml", "--duration", "2e-3", "--engine", "compiled")
    with tempfile.TemporaryDirectory() as folder:
        assert command(*words, "--out", folder)[0] == 0
        paths = [path for path in sorted(Path(folder).rglob("*")) if path.is_file()]
        return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def put(folder: Path, files: dict[str, bytes]) -> Path:
    """Write a folder of results, and nothing else."""
    out = folder / "results"
    shutil.rmtree(out, ignore_errors=True)
    for name, data in files.items():
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_bytes(data)
    return out


def reading(mutator: Mutator, folder: Path) -> str:
    """Report and export results, a file of which is damaged: an export has the numbers that were written, or none."""
    files = results(mutator.dice.choice(("simulate", "simulate", "wear")))
    pictures = [name for name in files if name.endswith((".png", ".block"))]
    name = mutator.dice.choice([name for name in files if name not in pictures] * 3 + pictures)
    out = put(folder, files | {name: mutator.result(name, files[name])})
    status, _, _ = command("report", out)
    assert status in (0, 2)
    assert (out / "report.html").exists() == (status == 0)
    if "trajectory.npz" not in files:
        return "refused" if status else "taken"
    kind, end = mutator.dice.choice((("csv", "csv"), ("mat", "mat"), ("parquet", "parquet"), ("netcdf", "nc")))
    exported, _, _ = command("export", out, "--to", kind)
    assert (out / f"trajectory.{end}").exists() == (exported == 0)
    if exported == 0 and kind == "csv":
        run = linkages.load_trajectory(out / "trajectory.npz")
        (out / "trajectory.npz").write_bytes(files["trajectory.npz"])
        whole = linkages.load_trajectory(out / "trajectory.npz")
        assert all(np.array_equal(run[key], column) for key, column in whole.columns.items()), "exports something else"
    return "refused" if status or exported else "taken"


def blocks(mutator: Mutator, folder: Path) -> str:
    """Go on with a life, a block of which is damaged: it is measured again, to the same bytes."""
    files = results("wear")
    name = mutator.dice.choice([name for name in files if name.endswith(".block")])
    out = put(folder, files | {name: mutator.damage(files[name])})
    assert command("wear", *_LIFE, "--no-plots", "--no-animation", "--out", out)[0] == 0
    assert (out / "wear.json").read_bytes() == files["wear.json"], "another life"
    assert (out / name).read_bytes() == files[name]
    return "taken"


TRIALS = {"load": load, "study": study, "store": store, "import": importing, "describe": describing}
TRIALS |= {"report": reading, "blocks": blocks}
TRIALS |= {engine: partial(simulate, engine) for engine in ("compiled", "drake")}
