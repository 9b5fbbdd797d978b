"""Twins of identification: machines of known values, fitted from blind starts with free gains, offsets and clocks.

    python benchmarks/identification_twins.py [--kind film|stribeck|dry] [--count 20] [--seed 1]

Each twin draws a slider-crank with a film, with Stribeck friction in its guide, or with dry contact: its values, speed,
sensors and noise. Runs at an accuracy of 1e-11 with white noise are the data; the fit has default settings, and starts
within a factor of two. A line for each twin has the errors in stated deviations, and the stated deviations in those of
an exact computation (the bound of Cramer and Rao, by central differences of tight runs). The last line counts.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import linkages
import optim

FACTOR = 2.0  # largest ratio of a start and the true value
ROOM = 4.0  # ratio of a limit and the true value
TIGHT = {"solver.accuracy": 1e-11}
STEP = 1e-4  # relative step of differences
LINEAR = 0.1  # exact deviation of a scaled value up to which the model counts as linear


class Twin(NamedTuple):
    """A machine, its true values by path, its columns (output, free values) and its samples."""

    experiment: str
    values: dict[str, float]
    columns: dict[str, tuple[str, ...]]
    times: np.ndarray


MECHANISM = 'mechanism = "slider_crank.sdf"\ngravity = [0.0, -9.81, 0.0]\noutputs = ["slider.x"]\n'


def film(rng: np.random.Generator) -> Twin:
    """Draw a slider-crank with a film between rod and slider."""
    speed = rng.uniform(60.0, 200.0)
    kind = rng.choice(["short", "long", "finite"])
    duration = 2.0 * np.pi / speed * rng.uniform(1.5, 3.0)
    text = MECHANISM + f"duration = {1.5 * duration}\n[drives.O]\nspeed = {speed}\n[joints.B]\nmodel = 'lubricated'\n"
    text += f"film = '{kind}'\nclearance = 2e-4\nviscosity = 0.1\n"
    values = {
        "joints.B.clearance": 1e-4 * 4.0 ** rng.uniform(0.0, 1.0),
        "joints.B.viscosity": 0.05 * 6.0 ** rng.uniform(0.0, 1.0),
        "sdf.links.slider.mass": rng.uniform(0.1, 0.3),
    }
    columns = {"slider.ax": ("gain", "offset"), "O.torque": ("gain", "offset"), "B.fx": ("offset",)}
    return Twin(text, values, columns, np.linspace(0.0, duration, int(rng.integers(300, 900))))


def stribeck(rng: np.random.Generator) -> Twin:
    """Draw a slow slider-crank with Stribeck friction in its guide."""
    speed = rng.uniform(3.0, 10.0)
    duration = 2.0 * np.pi / speed * rng.uniform(1.5, 3.0)
    text = MECHANISM + f"duration = {1.5 * duration}\n[drives.O]\nspeed = {speed}\n[frictions.rub]\njoint = 'guide'\n"
    text += "coefficient = 0.1\nstatic_coefficient = 0.2\nstribeck_speed = 0.1\nspeed = 0.005\n"
    low = rng.uniform(0.05, 0.2)
    values = {
        "frictions.rub.coefficient": low,
        "frictions.rub.static_coefficient": low * rng.uniform(1.5, 3.0),
        "frictions.rub.stribeck_speed": rng.uniform(0.1, 0.3) * 0.05 * speed,
    }
    columns = {"slider.x": ("gain", "offset"), "O.torque": ("gain", "offset")}
    return Twin(text, values, columns, np.linspace(0.0, duration, int(rng.integers(300, 900))))


def dry(rng: np.random.Generator) -> Twin:
    """Draw a slider-crank with dry contact between rod and slider: some impacts, or (each third) a long record."""
    speed = rng.uniform(100.0, 500.0)
    long = rng.random() < 1.0 / 3.0
    duration, rate = (rng.uniform(0.5, 1.0), 2e3) if long else (2.0 * np.pi / speed * rng.uniform(0.5, 1.5), 5e4)
    text = MECHANISM + f"duration = {1.5 * duration}\n[drives.O]\nspeed = {speed}\n[joints.B]\nmodel = 'dry'\n"
    text += "clearance = 3e-4\n[joints.B.contact]\nlaw = 'lankarani-nikravesh'\nrestitution = 0.8\n"
    text += "youngs_modulus = 207e9\npoissons_ratio = 0.3\n[joints.B.friction]\nlaw = 'ambrosio'\n"
    text += "coefficient = 0.05\nv_0 = 1e-4\nv_1 = 1e-3\n"
    values = {
        "joints.B.clearance": 1e-4 * 5.0 ** rng.uniform(0.0, 1.0),
        "joints.B.contact.restitution": rng.uniform(0.5, 0.9),
        "joints.B.friction.coefficient": rng.uniform(0.02, 0.1),
    }
    columns = {"slider.ax": ("gain", "offset"), "O.torque": ("gain", "offset"), "B.force": ("offset",)}
    return Twin(text, values, columns, np.linspace(0.0, duration, int(rate * duration)))


KINDS = {"film": film, "stribeck": stribeck, "dry": dry}


def readings(
    folder: Path, twin: Twin, values: np.ndarray, sensors: dict[str, list[float]], shift: float
) -> list[np.ndarray]:
    """Return the columns of the file: gain times them plus offset is the output, the clock is late."""
    end = float(twin.times[-1]) + abs(shift)
    system = linkages.load(folder / "twin.toml", dict(zip(twin.values, map(float, values), strict=True)) | TIGHT)
    system = system.replaced({"duration": end})
    run = linkages.simulate(system, "compiled", outputs=list(twin.columns))
    if run.status.value != "ok":
        raise RuntimeError(run.status.value)
    curves = run.evaluate(twin.times + shift)
    return [(curves[name] - offset) / gain for name, (gain, offset) in sensors.items()]


def bounds(
    folder: Path, twin: Twin, sensors: dict[str, list[float]], shift: float, sizes: list[float]
) -> dict[str, float]:
    """Return the deviations that are possible at best, by name, from central differences of tight runs."""
    true, rows, names = np.array(list(twin.values.values())), [], []

    def column(values: np.ndarray, others: dict[str, list[float]], late: float) -> np.ndarray:
        parts = readings(folder, twin, values, others, late)
        return np.concatenate([part / size for part, size in zip(parts, sizes, strict=True)])

    for k, path in enumerate(twin.values):
        move = STEP * true * np.eye(len(true))[k]
        rows.append((column(true + move, sensors, shift) - column(true - move, sensors, shift)) / (2.0 * move[k]))
        names.append(path)
    step = STEP * float(np.diff(twin.times).mean())
    rows.append((column(true, sensors, shift + step) - column(true, sensors, shift - step)) / (2.0 * step))
    names.append("run.shift")
    for i, (output, free) in enumerate(twin.columns.items()):
        for what in free:
            place = ("gain", "offset").index(what)
            size = STEP * (sensors[output][0] if place == 0 else sizes[i])
            ends = []
            for sign in (1.0, -1.0):
                other = {name: list(pair) for name, pair in sensors.items()}
                other[output][place] += sign * size
                ends.append(column(true, other, shift))
            rows.append((ends[0] - ends[1]) / (2.0 * size))
            names.append(f"run.c{i}.{what}")
    jacobian = np.array(rows).T
    scale = np.linalg.norm(jacobian, axis=0)
    covariance = np.linalg.pinv((jacobian / scale).T @ (jacobian / scale)) / np.outer(scale, scale)
    return dict(zip(names, np.sqrt(np.diag(covariance)), strict=True))


def fitted(kind: str, seed: int, folder: Path) -> dict[str, Any]:
    """Draw, write and fit a twin; return errors, stated and exact deviations by name, and the time."""
    rng = np.random.default_rng([seed, sorted(KINDS).index(kind)])
    twin = KINDS[kind](rng)
    (folder / "slider_crank.sdf").write_bytes(linkages.find_file("slider_crank.sdf").read_bytes())
    (folder / "twin.toml").write_text(twin.experiment, encoding="utf-8")
    shift = float(rng.uniform(0.0, 0.02) * twin.times[-1])
    plain = readings(folder, twin, np.array(list(twin.values.values())), {n: [1.0, 0.0] for n in twin.columns}, shift)
    sensors, sizes = {}, []
    for (name, free), curve in zip(twin.columns.items(), plain, strict=True):
        gain = float(1.25 ** rng.uniform(-1.0, 1.0)) if "gain" in free else 1.0
        offset = float(rng.uniform(-1.0, 1.0) * np.std(curve)) if "offset" in free else 0.0
        sensors[name] = [gain, offset]
        sizes.append(float(rng.uniform(0.005, 0.02) * np.std(curve) / gain))
    columns = readings(folder, twin, np.array(list(twin.values.values())), sensors, shift)
    noisy = [c + s * rng.standard_normal(len(c)) for c, s in zip(columns, sizes, strict=True)]
    heads = ",".join(["t", *(f"c{k}" for k in range(len(noisy)))])
    np.savetxt(folder / "run.csv", np.column_stack([twin.times, *noisy]), delimiter=",", header=heads, comments="")
    lines = ['experiment = "twin.toml"', "[data.run]", 'file = "run.csv"', 'time = { column = "t", shift = "fit" }']
    true = twin.values | {"run.shift": shift}
    for k, ((name, free), size) in enumerate(zip(twin.columns.items(), sizes, strict=True)):
        lines += [f"[data.run.columns.c{k}]", f'output = "{name}"', f"deviation = {size}"]
        lines += [f'{what} = "fit"' for what in free]
        true |= {f"run.c{k}.{what}": sensors[name][("gain", "offset").index(what)] for what in free}
    for path, value in twin.values.items():
        upper = 0.99 if path.endswith("restitution") else ROOM * value
        start = min(value * FACTOR ** rng.uniform(-1.0, 1.0), 0.98 * upper)
        lines += [f'[unknowns."{path}"]', f'path = "{path}"', f"lower = {value / ROOM}", f"upper = {upper}"]
        lines.append(f"start = {start}")
    (folder / "task.toml").write_text("\n".join(lines), encoding="utf-8")
    task = optim.load_identification(folder / "task.toml")
    begun = time.perf_counter()
    found = optim.identify(task)
    seconds = time.perf_counter() - begun
    rows = {**found["parameters"], **found["nuisance"]}
    exact = bounds(folder, twin, sensors, shift, sizes) if kind != "dry" else {}
    return {
        "seconds": seconds, "horizon": found["fitted_until"] / float(twin.times[-1]), "warnings": found["warnings"],
        "rows": {name: (row["value"], row["deviation"], true[name], exact.get(name)) for name, row in rows.items()},
        "intervals": [
            row["interval"][0] <= true[name] <= row["interval"][1]
            for name, row in found["parameters"].items() if row["interval"]
        ],
    }  # fmt: skip


def main() -> None:
    """Print a line for each twin and the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kind", choices=KINDS, action="append")
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1, help="of the first twin")
    parser.add_argument("--warnings", action="store_true", help="print the warnings of each fit")
    given = parser.parse_args()
    for kind in given.kind or KINDS:
        intervals, errors, ratios, seconds = [], [], [], []
        for seed in range(given.seed, given.seed + given.count):
            with tempfile.TemporaryDirectory() as folder:
                try:
                    one = fitted(kind, seed, Path(folder))
                except (RuntimeError, linkages.RunError) as problem:
                    print(f"{kind} {seed}: {problem}", flush=True)
                    continue
            parts = []
            for name, (value, deviation, true, exact) in one["rows"].items():
                if deviation:
                    errors.append((value - true) / deviation)
                    text = f"{errors[-1]:+.2f}"
                    linear = max(abs(value), 1e-300) if name in one["rows"] and not name.startswith("run.") else np.inf
                    if exact and exact < LINEAR * linear:
                        ratios.append(deviation / exact)
                        text += f" ({ratios[-1]:.2f})"
                else:
                    text = f"not known, off by {value / true if true else value:.3g}"
                parts.append(f"{name.split('.', 1)[1]} {text}")
            intervals += one["intervals"]
            seconds.append(one["seconds"])
            print(f"{kind} {seed}, {one['seconds']:.1f} s, up to {one['horizon']:.2f}: {', '.join(parts)}", flush=True)
            for line in one["warnings"] if given.warnings else ():
                print(f"    {line}", flush=True)
        size, share = np.abs(errors or [np.nan]), np.mean(intervals or [np.nan])
        print(
            f"{kind}: {len(seconds)} twins; intervals of unknowns hold {share:.3f} of {len(intervals)};"
            f" all errors within 1.96 deviations {np.mean(size < 1.96):.3f} of {len(errors)}, largest {size.max():.2f};"
            f" deviations in exact ones {min(ratios, default=np.nan):.2f} to {max(ratios, default=np.nan):.2f};"
            f" longest fit {max(seconds, default=np.nan):.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
