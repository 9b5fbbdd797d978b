"""Time of runs with flexible links against rigid ones: ``python benchmarks/flexible_links.py [--machine seven_bar]``.

Simeon's slider-crank with a lubricated joint at the slider, or the press with seven links and two lubricated joints, of
which three links are flexible steel bars, 10 mm high. For each model the error of an orbit is the error of the
journal's place over the run, against the same model at a hundred times tighter tolerance; models take turns, and CPU
times are medians of the turns. The last column compares with the time in which the rigid machine has the same error, on
lines interpolated between its logarithms.
"""

from __future__ import annotations

import argparse
import re
import tempfile
import time
from pathlib import Path

import numpy as np

import linkages
from linkages.engines.compiled.run.runner import Runner
from linkages.engines.compiled.simulation import simulate

EXPERIMENT = """mechanism = "{machine}"
duration = 0.2
[drives.O]
speed = 150.0
[joints.B]
model = "lubricated"
clearance = 1e-4
viscosity = 0.1
[links.rod]
model = "flexible"
"""
PRESS = {"link2": ("C", 0.18, 0.219), "link3": ("C", 0.318, 0.374), "link6": ("D", 0.3, 0.354)}  # to, m, kg, as drawn
HEIGHT, DENSITY = 0.01, 7870.0  # m, kg/m3
BEAM = """<linkages:beam><linkages:from>{name}</linkages:from><linkages:to>{name}_{to}</linkages:to>
<linkages:rectangle><linkages:width>{width}</linkages:width><linkages:height>{height}</linkages:height></linkages:rectangle>
<linkages:material><linkages:youngs_modulus>2e11</linkages:youngs_modulus><linkages:density>{density}</linkages:density>
</linkages:material></linkages:beam>
"""
#: Experiment and flexible links.
MACHINES = {"slider_crank": ("rod",), "seven_bar": tuple(PRESS)}
MODELS = {
    "rigid": {"model": "rigid"},
    "2 bending": {"bending": 2, "axial": 0},
    "4 bending, 1 axial": {"bending": 4, "axial": 1},
}
ACCURACIES = (1e-5, 1e-6, 1e-7)
RIGID = (1e-4, *ACCURACIES, 1e-8)  # so that the rigid machine's errors enclose the others'


def press():
    """SDFormat text of the shipped press with beams; moments of inertia are the bars'."""
    text = linkages.find_file("seven_bar.sdf").read_text(encoding="utf-8")
    for name, (to, length, mass) in PRESS.items():
        head, rest = text.split(f'<link name="{name}">')
        width = mass / (length * HEIGHT * DENSITY)
        link, tail = rest.split("</link>", 1)
        link = re.sub(r"<(iyy|izz)>[^<]*<", rf"<\g<1>>{mass * length**2 / 12.0}<", link)
        beam = BEAM.format(name=name, to=to, width=width, height=HEIGHT, density=DENSITY)
        text = f'{head}<link name="{name}">{link}{beam}</link>{tail}'
    return text


def load(machine, folder):
    """One of the machines, its links flexible with default modes."""
    path = folder / "machine.toml"
    if machine == "slider_crank":
        path.write_text(EXPERIMENT.format(machine=linkages.find_file("slider_crank_flexible.sdf")))
        return linkages.load(path)
    (folder / "seven_bar.sdf").write_text(press())
    text = Path(__file__).with_name("seven_bar_fast.toml").read_text(encoding="utf-8")
    text = text.replace("../sdf/seven_bar.sdf", "seven_bar.sdf")
    path.write_text(text + "".join(f'\n[links.{name}]\nmodel = "flexible"\n' for name in PRESS))
    return linkages.load(path)


def orbit(system):
    """Eccentricity vector over the run in parts of the clearance, (2, nt)."""
    values = simulate(system).evaluate(np.linspace(0.0, system.experiment.duration, 2001))
    return np.array([values["B.ex"], values["B.ey"]]) / system.experiment.joints["B"].clearance


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=9)
    parser.add_argument("--machine", choices=MACHINES, default="slider_crank")
    options = parser.parse_args()
    links, repeat = MACHINES[options.machine], options.repeat
    models = {n: {f"links.{link}.{k}": v for link in links for k, v in keys.items()} for n, keys in MODELS.items()}
    with tempfile.TemporaryDirectory() as folder:
        plain = load(options.machine, Path(folder))
        cases = {
            (name, a): plain.replaced({**v, "solver.accuracy": a})
            for name, v in models.items()
            for a in (RIGID if name == "rigid" else ACCURACIES)
        }
        exact = {
            name: orbit(plain.replaced({**v, "solver.accuracy": ACCURACIES[-1] / 100})) for name, v in models.items()
        }
        errors = {case: np.abs(orbit(system) - exact[case[0]]).max() for case, system in cases.items()}
        spent = {case: [] for case in cases}
        for _ in range(repeat):
            for case, system in cases.items():
                runner = Runner(system)
                start = time.process_time()
                runner.run(0.0, runner.start, 0.0, 10**7)
                spent[case].append(time.process_time() - start)
        known = np.log([errors["rigid", a] for a in reversed(RIGID)])
        turns = np.log([spent["rigid", a] for a in reversed(RIGID)]).T
        print("model               accuracy  orbit error [c]  ms per simulated s  of rigid at this error")
        for (name, accuracy), system in cases.items():
            error = errors[name, accuracy]
            rigid = np.exp([np.interp(np.log(error), known, turn) for turn in turns])
            cost = 1e3 * np.median(spent[name, accuracy]) / system.experiment.duration
            ratio = np.median(spent[name, accuracy] / rigid)
            print(f"{name:20s}{accuracy:8.0e}{error:17.1e}{cost:20.1f}{ratio:24.2f}")


if __name__ == "__main__":
    main()
