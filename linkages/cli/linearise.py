"""``linkages linearise``: a linear state-space model, its poles and its frequency response."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from linkages.base.errors import InputError, listed
from linkages.cli.options import (
    add_experiment,
    add_names,
    add_units,
    load_system,
    output_folder,
    print_results,
    record,
    seconds,
)
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.explore.linearisation import StateSpace

HELP = "a linear state-space model at a state or an equilibrium: A, B, C, D, poles, frequency response"
WRITES = {"linearise": ("linear.json", "linear.npz", "bode.png")}

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = ("slider_crank_motor.toml --time 0.001 --output slider.x --output B.force",)

EXAMPLES = """examples:
  linkages linearise my.toml --equilibrium --output slider.x
  linkages linearise my.toml --time 0.2 --input O.torque --output slider.x --frequencies 1:1000:300
"""
_MOST = 100_000  # frequencies
_ERROR = 1e-6  # relative error of C and D that is worth a warning
_SHOWN = 20  # most poles in the table


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_experiment(parser)
    add_units(parser)
    parser.add_argument("--time", type=seconds, default=0.0, metavar="SECONDS", help="time of the state; default: 0")
    parser.add_argument("--equilibrium", action="store_true", help="find an equilibrium near the state of that time")
    add_names(parser, "--input", "DRIVE.torque, TORQUE.torque, FORCE.fx, FORCE.fy; may be repeated; default: all")
    default = "default: the experiment's, else the coordinates"
    add_names(parser, "--output", f"output, see `linkages keys`; may be repeated; {default}")
    frequencies = "frequencies of the response [Hz], in equal ratios; default: by the poles"
    parser.add_argument("--frequencies", metavar="LO:HI:N", help=frequencies)


def run(options: argparse.Namespace) -> int:
    """Linearise and write the model; return the exit status."""
    import numpy as np

    from linkages.explore.linearisation import linearise

    given = None if options.frequencies is None else _range(options.frequencies)
    system = load_system(options)
    out = output_folder(options, f"{system.description.stem}_linear", "linearise")
    found = linearise(system, options.output, options.input, options.time, options.equilibrium)
    low, high, count = given or _usual(found)
    frequencies = np.geomspace(low, high, count)
    response = found.frequency_response(2.0 * np.pi * frequencies)
    title = system.description.heading
    result = content(title, found)
    with out as folder:
        write_json(folder / "linear.json", result)
        found.save(folder / "linear.npz")
        if not options.no_plots and response.size:
            from linkages.show.plots.linear_figures import bode_figure
            from linkages.show.plots.style import write_figure

            write_figure(bode_figure(found, frequencies, response), folder / "bode")
        from linkages.show.report.tables import linear

        table = format_model(result)
        what = f"{listed(result['outputs'])} to {listed(result['inputs'] or ['a disturbed state'])}"
        question = f"How do small motions about the {_where(result)} respond: {what}?"
        record(options, folder, title, question, _answer(result), table, linear(result))
    print_results(options, table, out)
    return 0


def content(title: str, found: StateSpace) -> dict[str, Any]:
    """Return the content of ``linear.json``, SI units; docs/linearise.md explains it."""
    named = zip(found.states, found.x, strict=True), zip(found.outputs, found.y, strict=True)
    return {
        "title": title,
        "time": found.time,
        "at_rest": found.at_rest,
        "states": {name: float(value) for name, value in named[0]},
        "inputs": {name: found.units[name] for name in found.inputs},
        "outputs": {name: {"unit": found.units[name], "value": float(value)} for name, value in named[1]},
        "poles": [[float(pole.real), float(pole.imag)] for pole in found.poles],
        "error": found.error,
        **{key: getattr(found, key).tolist() for key in "ABCD"},
    }


def format_model(result: dict[str, Any]) -> str:
    """Format the content of ``linear.json`` as lines of text."""
    lines = [
        f"{result['title']}: linear model at t = {result['time']:g} s, {_where(result)}",
        f"states: {', '.join(result['states'])}",
        f"inputs: {', '.join(result['inputs']) or 'none'}",
        f"outputs: {', '.join(result['outputs'])}",
        "",
        *_operating_point(result),
        "",
        f"{'pole [1/s]':>28s}{'frequency [Hz]':>17s}{'damping [1]':>14s}",
    ]
    upper = [complex(*pole) for pole in result["poles"] if pole[1] >= 0.0]
    for pole in upper[:_SHOWN]:
        pair = f"{pole.real:.5g}" + (f" ± {pole.imag:.5g} i" if pole.imag else "")
        frequency = f"{abs(pole) / (2.0 * math.pi):.5g}" if pole.imag else "-"
        damping = f"{-pole.real / abs(pole):.4g}" if pole.imag else "-"
        lines.append(f"{pair:>28s}{frequency:>17s}{damping:>14s}")
    if len(upper) > _SHOWN:
        lines.append(f"{f'and {len(upper) - _SHOWN} more':>28s}")
    if any(pole.real > 0.0 for pole in upper):
        lines += ["", "the linear model is unstable: a pole has a positive real part"]
    if not result["at_rest"]:
        lines += ["", "warning: the state is not an equilibrium; the model holds for a short time (--equilibrium)"]
    if result["error"] > _ERROR:
        lines += ["", f"warning: C and D have a relative error of {result['error']:.1g}: an output is not smooth here"]
    return "\n".join(lines)


def _operating_point(result: dict[str, Any]) -> list[str]:
    """Format the outputs, then the states, at the operating point."""
    from linkages.show.plots.presentation import shown

    lines = [f"{'operating point':36s}{'value':>14s}"]
    for name, one in result["outputs"].items():
        unit, factor = shown(one["unit"])
        lines.append(f"{f'{name} [{unit}]':36s}{factor * one['value']:14.6g}")
    return lines + [f"{f'state {name}':36s}{value:14.6g}" for name, value in result["states"].items()]


def _where(result: dict[str, Any]) -> str:
    return "equilibrium" if result["at_rest"] else "state in motion"


def _answer(result: dict[str, Any]) -> list[str]:
    poles = [complex(*pole) for pole in result["poles"]]
    slowest = max((pole.real for pole in poles), default=0.0)
    kind = "unstable: a disturbance grows" if slowest > 0.0 else "stable: the slowest disturbance decays"
    said = [f"The linear model is {kind} by a factor of e in {1.0 / abs(slowest):.4g} s."] if slowest else []
    if ringing := [abs(pole) for pole in poles if pole.imag]:
        said.append(f"Its lowest natural frequency is {min(ringing) / (2.0 * math.pi):.4g} Hz.")
    return said or ["The linear model neither decays nor grows."]


def _usual(found: StateSpace) -> tuple[float, float, int]:
    """Choose frequencies from a tenth of the lowest pole's to ten times the highest pole's [Hz]."""
    size = [abs(pole) for pole in found.poles if abs(pole) > 1e-9 * max(map(abs, found.poles), default=0.0)]
    low, high = (min(size), max(size)) if size else (1.0, 1.0)
    return 0.1 * low / (2.0 * math.pi), 10.0 * high / (2.0 * math.pi), 600


def _range(text: str) -> tuple[float, float, int]:
    try:
        low, high, count = text.split(":")
        found = float(low), float(high), int(count)
    except ValueError:
        raise InputError("--frequencies", text, "write LO:HI:N [Hz], such as 0.1:1000:300") from None
    if not (0.0 < found[0] < found[1] < math.inf and 2 <= found[2] <= _MOST):
        raise InputError("--frequencies", text, f"needs 0 < LO < HI and N from 2 to {_MOST}")
    return found
