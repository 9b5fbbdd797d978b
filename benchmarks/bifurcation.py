"""Bifurcation diagram of the dry slider-crank against drive speed: ``python benchmarks/bifurcation.py``.

Runs ``slider_crank_dry.toml`` at 300 speeds, discards 40 revolutions and keeps 60 of each, and prints wall and CPU
time, compilation not counted. With ``--out FOLDER`` it also draws the figures of docs/nonlinear.md there, and prints
the tables of that page: up to when runs at two tolerances agree, and the largest Lyapunov exponents, for several
coefficients of friction.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from tqdm import tqdm

from linkages import load
from linkages.base.errors import Status
from linkages.engines.assessment import simulate
from linkages.explore.flow import lasting
from linkages.explore.lyapunov import largest_exponent
from linkages.explore.sections import horizon, stroboscopic
from linkages.explore.spectra import spectrum
from linkages.explore.sweep import sweep
from linkages.input.files.shipped import data_folder
from linkages.results.outputs.registry import unit

FILE = data_folder() / "slider_crank_dry.toml"
RPM = np.pi / 30.0  # rad/s
SPEEDS = (100.0, 6000.0)  # r/min
NAMES = ("B.ey", "B.force")
FRICTION = {"0": 1e-9, "0.03": 0.03, "0.1": 0.1}  # the experiment's table cannot be taken out: 1e-9 is none
ACCURACIES = (1e-7, 1e-9, 1e-11)
ACCURACY = 1e-6  # of the diagram: 10 nm in a clearance of 0.5 mm


def diagram(values: int, revolutions: int, transient: int, threads: int | None):
    """Sweep over the speeds; returns the sweep, wall and CPU seconds."""
    system = load(FILE, {"solver.accuracy": ACCURACY})
    sweep(system, "drives.O.speed", [500.0], NAMES, 1)  # compiles
    speeds = RPM * np.linspace(*SPEEDS, values)
    bar = tqdm(total=1.0, desc="bifurcation", disable=None, bar_format="{l_bar}{bar}| [{elapsed}<{remaining}]")

    def advance(done: float) -> None:
        bar.update(done - bar.n)

    started = time.perf_counter(), time.process_time()
    result = sweep(system, "drives.O.speed", speeds, NAMES, revolutions, transient, threads=threads, progress=advance)
    bar.close()
    return result, time.perf_counter() - started[0], time.process_time() - started[1]


def tables():
    """Print horizons and exponents for each friction; returns the exponents."""
    exponents = {}
    tolerances = ", ".join(f"{a:g}" for a in ACCURACIES)
    print(f"\nfriction   revolutions together at accuracies a and 10 a, a = {tolerances}", end="")
    print("   largest exponent [1/revolution]")
    for label, coefficient in FRICTION.items():
        system = load(FILE, {"joints.B.friction.coefficient": coefficient})
        found = [horizon(system.replaced({"solver.accuracy": accuracy}), 40.0) for accuracy in ACCURACIES]
        exponent = largest_exponent(system, 150, 30, renormalisations=40)
        exponents[f"friction {label}"] = exponent
        value, error = exponent.per_revolution, exponent.error * exponent.period
        print(f"{label:11s}" + "".join(f"{turns:8.2f}" for turns in found) + f"   {value:.2f} ± {error:.2f}")
    return exponents


def draw(result, exponents, folder: Path) -> None:
    """Draw the figures of docs/nonlinear.md."""
    from linkages.show.plots import bifurcation_figure, exponent_figure, section_figure, spectrum_figure

    system = load(FILE)
    units = {name: unit(system, name) for name in NAMES}
    section = stroboscopic(system, ("B.ey", "B.sliding"), 3000, 50)
    spectra = {}
    for label in ("0.03", "0.1"):
        case = system.replaced({"joints.B.friction.coefficient": FRICTION[label]})
        run = simulate(lasting(case, 60.0), "compiled")
        spectra[f"friction {label}"] = spectrum(run, "slider.ax", 20.0 * section.period, 2**18, segments=4)
    rows, label = (("B.ey", "strobe"), ("B.force", "peaks")), "speed of the crank [r/min]"
    for name, figure in {
        "bifurcation": bifurcation_figure(result, units, label, rows, scale=1.0 / RPM, logarithmic=("B.force",)),
        "exponents": exponent_figure(exponents),
        "section": section_figure(section.strobe, "B.ey", "B.sliding", ("m", "m/s")),
        "spectrum": spectrum_figure(spectra, unit(system, "slider.ax"), drive=1.0 / section.period),
    }.items():
        figure.savefig(folder / f"nonlinear_{name}.png")


def main() -> None:
    """Print the times; draw and print more if asked."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    for name, default in {"--values": 300, "--revolutions": 60, "--transient": 40}.items():
        parser.add_argument(name, type=int, default=default)
    parser.add_argument("--threads", type=int)
    parser.add_argument("--out", type=Path, help="folder for the figures of docs/nonlinear.md")
    options = parser.parse_args()
    result, wall, cpu = diagram(options.values, options.revolutions, options.transient, options.threads)
    good = sum(point.status is Status.OK for point in result.points)
    print(
        f"{options.values} speeds, {options.transient} + {options.revolutions} revolutions each:"
        f" {wall:.1f} s wall, {cpu:.1f} s CPU, {good} runs reached their end"
    )
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        draw(result, tables(), options.out)


if __name__ == "__main__":
    main()
