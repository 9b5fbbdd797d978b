"""Compare stated errors of peaks with true ones, on random mechanisms: ``python benchmarks/stated_errors.py``.

Draws random experiments: slider-cranks, four-bars, five-bars and six-bars of random lengths, the shipped press, a
flexible rod, double pendulums; ideal, dry, lubricated and mixed joints; random clearances, viscosities, speeds,
frictions and accuracies. Each stated error is compared with the true one: the difference of the peak from a run of the
compiled engine at an accuracy of 1e-12, with twelve bending modes where Drake divides a link into rigid segments. A
stated error fails if it is less than half of the true one, and the true one exceeds 1e-6 of the peak. Errors that are
null are counted. The exit status is 1 if a stated error fails.

``--engine drake`` judges Drake's runs. ``--count`` is the number of experiments whose runs reach their end, ``--seed``
chooses them, ``--only K`` judges the K-th that is drawn.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import tomlkit

from linkages import assess, load, summarize
from linkages.base.errors import AssemblyError, Status
from linkages.cli.new import described_files, write_files
from linkages.engines.assessment import simulate
from linkages.input.files.shipped import find_file
from linkages.results.characteristics import numbers
from linkages.results.shape import peaks_by_key
from linkages.system import System

ACCURACY = 1e-12  # of the run that is taken for the truth
NEGLIGIBLE = 1e-6  # of the peak: true errors below it are not judged
MODES = 12  # bending modes of the truth for rigid segments, which have no modal truncation
SAFE = 0.5  # least ratio of a stated error to the true one
ACCURACIES = {"compiled": (-9.0, -3.0), "drake": (-7.0, -3.0)}  # decimal logarithms of the accuracies that are drawn

SECTION = "section = [0.02, 0.01]\ndensity = 7850.0\n"  # m, kg/m3: of the machines that are described

Draw = np.random.Generator


class Row(NamedTuple):
    """A peak: its key, value, stated error (None: null) and true error."""

    key: str
    peak: float
    stated: float | None
    true: float

    @property
    def judged(self) -> bool:
        """Whether an error is stated and the true one is large enough to be judged."""
        return self.stated is not None and self.true > NEGLIGIBLE * self.peak

    @property
    def fails(self) -> bool:
        """Whether the stated error is too small."""
        return self.judged and self.stated < SAFE * self.true


def _log(rng: Draw, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform, with four digits."""
    return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.4g}")


def _between(rng: Draw, low: float, high: float) -> float:
    return float(f"{rng.uniform(low, high):.4g}")


def _play(rng: Draw) -> dict[str, Any]:
    """Draw a model of a clearance joint."""
    model = str(rng.choice(["dry", "dry", "lubricated", "lubricated", "mixed"]))
    joint: dict[str, Any] = {"model": model, "clearance": _log(rng, 3e-5, 5e-4)}
    if model != "lubricated":
        joint["contact"] = {
            "law": str(rng.choice(["lankarani-nikravesh", "flores", "hunt-crossley"])),
            "restitution": _between(rng, 0.5, 0.95),
            "youngs_modulus": 207e9,
            "poissons_ratio": 0.3,
        }
        if rng.random() < 0.7:
            friction = {"law": "ambrosio", "coefficient": _between(rng, 0.01, 0.15), "v_0": 1e-4, "v_1": 1e-3}
            joint["friction"] = friction
    if model != "dry":
        joint["film"] = str(rng.choice(["finite", "pinkus-sternlicht"])) if model == "lubricated" else "finite"
        joint["viscosity"] = _log(rng, 0.05, 2.0) if model == "lubricated" else _log(rng, 1e-4, 1e-2)
    if model == "mixed":
        joint["mixed"] = {"law": "blend", "transition": 2e-6, "film_limit": 0.99}
    return joint


def _experiment(rng: Draw, drives: dict[str, float], joints: list[str], outputs: list[str]) -> dict[str, Any]:
    """Draw an experiment of a driven machine: one to two and a half revolutions of the first drive."""
    chosen = [name for name in joints if rng.random() < 0.6]
    turns = _between(rng, 0.2, 2.0)
    return {
        "duration": turns * 2.0 * np.pi / abs(next(iter(drives.values()))),
        "gravity": [0.0, float(rng.choice([0.0, -9.81])), 0.0],
        "outputs": outputs,
        "drives": {name: {"speed": speed} for name, speed in drives.items()},
        "joints": {name: _play(rng) for name in chosen},
    }


def _slider_crank(rng: Draw) -> dict[str, Any]:
    crank = _between(rng, 0.03, 0.08)
    experiment = _experiment(rng, {"O": _log(rng, 10.0, 500.0)}, ["A", "B"], ["ram.x", "ram.vx", "ram.ax"])
    return experiment | {
        "parameters": {"r": crank, "l": _between(rng, 2.2, 4.0) * crank},
        "links": {"ground": "O", "crank": "O A", "rod": "A B", "ram": "B along ground"},
        "points": {"O": [0, 0], "A": ["O", "r", "0.7 rad"], "B": ["A.x + sqrt(l**2 - A.y**2)", 0.0]},
    }


def _four_bar(rng: Draw) -> dict[str, Any]:
    outputs = ["follower.angle", "follower.alpha", "coupler.omega"]
    experiment = _experiment(rng, {"O": _log(rng, 5.0, 200.0)}, ["A", "B"], outputs)
    ground = _between(rng, 0.25, 0.35)
    return experiment | {
        "parameters": {"a": _between(rng, 0.06, 0.1), "b": _between(rng, 0.24, 0.3), "c": _between(rng, 0.18, 0.22)},
        "links": {"ground": "O Q", "crank": "O A", "coupler": "A B", "follower": "Q B"},
        "points": {"O": [0, 0], "Q": [ground, 0], "A": ["O", "a", "0.5 rad"], "B": ["Q", "c", "A", "b"]},
    }


def _five_bar(rng: Draw) -> dict[str, Any]:
    speed = _log(rng, 5.0, 100.0)
    drives = {"O": speed, "Q": -speed * float(rng.choice([1, 2]))}
    experiment = _experiment(rng, drives, ["A", "C"], ["left.omega", "right.alpha"])
    return experiment | {
        "links": {"ground": "O Q", "crank": "O A", "left": "A C", "right": "B C", "other": "Q B"},
        "points": {
            "O": [0, 0], "Q": [0.2, 0], "A": ["O", 0.08, "0.4 rad"], "B": ["Q", 0.08, "2.5 rad"],
            "C": ["A", _between(rng, 0.19, 0.25), "B", _between(rng, 0.2, 0.25)],
        },
    }  # fmt: skip


def _pendulum(rng: Draw) -> dict[str, Any]:
    """Draw a double pendulum that falls from a random pose, or whose upper link is driven."""
    first, second = (f"{rng.uniform(-0.5, 3.0):.4g} rad" for _ in range(2))
    driven = {"O": {"speed": _log(rng, 3.0, 10.0)}} if rng.random() < 0.2 else {}
    return {
        "duration": _between(rng, 0.5, 8.0),
        "gravity": [0.0, -9.81, 0.0],
        "outputs": ["lower.omega", "P.x", "upper.alpha"],
        "drives": driven,
        "links": {"ground": "O", "upper": "O A", "lower": "A P"},
        "points": {
            "O": [0, 0],
            "A": ["O", _between(rng, 0.1, 0.4), first],
            "P": ["A", _between(rng, 0.1, 0.4), second],
        },
    }


def _shipped(rng: Draw, name: str, joints: list[str], limits: tuple[float, float]) -> dict[str, Any]:
    """Draw an experiment of a shipped machine."""
    given = tomlkit.parse(find_file(f"{name}.toml").read_text(encoding="utf-8")).unwrap()
    speed = _log(rng, *limits)
    experiment = _experiment(rng, dict.fromkeys(given["drives"], speed), joints, given["outputs"])
    more = {"links": given["links"]} if "links" in given else {}
    return experiment | more | {"mechanism": str(find_file(given["mechanism"]))}


MACHINES = {
    "slider-crank": _slider_crank,
    "four-bar": _four_bar,
    "five-bar": _five_bar,
    "double pendulum": _pendulum,
    "six-bar": lambda rng: _shipped(rng, "six_bar_dry", ["A", "C"], (5.0, 60.0)),
    "press": lambda rng: _shipped(rng, "seven_bar", ["A", "B"], (2.0, 40.0)),
    "flexible": lambda rng: _shipped(rng, "slider_crank_flexible", ["B"], (30.0, 200.0)),
}  # fmt: skip


def experiments(seed: int, engine: str, folder: Path) -> Iterator[tuple[str, System]]:
    """Draw random experiments without end, each with the name of its machine; they lie in a folder."""
    rng, names, k = np.random.default_rng(seed), list(MACHINES), 0
    while True:
        name = names[k % len(names)]
        data = MACHINES[name](rng)
        data["solver"] = {"accuracy": _log(rng, *(10.0**power for power in ACCURACIES[engine]))}
        if rng.random() < 0.2:
            data["solver"]["max_step"] = float(f"{data['duration'] / rng.uniform(200, 2000):.3g}")
        if engine == "drake":  # the rigid segments of its links do not stretch
            for link in data.get("links", {}).values():
                if isinstance(link, dict) and link.get("model") == "flexible":
                    link["axial"] = 0
        stem = f"machine{k}"
        text = tomlkit.dumps(data)
        if "mechanism" in data:  # a shipped machine, else a described one
            path = folder / f"{stem}.toml"
            path.write_text(text, encoding="utf-8")
        else:
            source = folder / f"{stem}.machine.toml"
            source.write_text(SECTION + text, encoding="utf-8")
            _, path = write_files(stem, described_files(stem, source)[0], folder)
        k += 1
        yield name, load(path)


def rows(system: System, engine: str) -> list[Row] | None:
    """Judge every stated error of an experiment; None if the run or the true one does not reach its end."""
    try:
        found = assess(system, engine)
        exact: dict[str, float] = {"solver.accuracy": ACCURACY}
        if engine == "drake":
            exact |= {f"links.{name}.bending": MODES for name in system.experiment.deforming}
        truth = simulate(system.replaced(exact), "compiled")
    except AssemblyError:
        return None
    if found.run.status is not Status.OK or truth.status is not Status.OK:
        return None
    summary = summarize(found)
    true = peaks_by_key(numbers(system, truth, found.meaningless))
    return [
        Row(key, peak, summary["error"][key], abs(peak - true[key]))
        for key, peak in peaks_by_key(summary).items()
        if peak is not None and true.get(key) is not None
    ]


def main() -> int:
    """Check random experiments and print the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--engine", choices=("compiled", "drake"), default="compiled")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="judge this experiment only, counted from 0")
    options = parser.parse_args()
    every: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        drawn = experiments(options.seed, options.engine, Path(folder))
        count = 0
        for k, (name, system) in enumerate(drawn):
            if options.only is not None and k < options.only:
                continue
            if count == options.count or (options.only is not None and k > options.only):
                break
            found = rows(system, options.engine)
            experiment = system.experiment
            models = ", ".join(f"{joint} {experiment.joints[joint].model}" for joint in experiment.play) or "ideal"
            if found is None:
                print(f"{k:3d} {name}: {models}: ended early", flush=True)
                continue
            every += found
            count += 1
            null, failed = sum(row.stated is None for row in found), [row for row in found if row.fails]
            print(f"{k:3d} {name}: {models}; accuracy {experiment.solver.accuracy:.1e}: {len(found)} peaks, ", end="")
            print(f"{null} null, {sum(row.judged for row in found)} judged, {len(failed)} fail", flush=True)
            for row in failed:
                parts = row.stated / row.peak, row.true / row.peak
                print(f"      {row.key}: stated {parts[0]:.1e} of the peak, true {parts[1]:.1e}")
    judged = [row for row in every if row.judged]
    ratios = np.array([row.stated / row.true for row in judged] or [1.0])
    print(f"{len(every)} peaks, {sum(row.stated is None for row in every)} null, {len(judged)} judged, ", end="")
    print(f"{sum(row.fails for row in judged)} fail; stated over true: median {np.median(ratios):.2g}")
    return int(any(row.fails for row in judged))


if __name__ == "__main__":
    sys.exit(main())
