"""``linkages bearing``: a journal bearing under a static load."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from linkages.base.errors import InputError, nearest
from linkages.cli.options import add_out, add_pictures, add_units, number, output_folder, print_results, record
from linkages.cli.progress import progress_bar
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.explore.bearing import BearingPoint

HELP = "a journal bearing under a static load: eccentricity, flow, friction, dynamic coefficients, stability"
WRITES = {"bearing": ("bearing.json", "bearing_chart.png", "bearing_pressure.png")}

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = ("--diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000",)

EXAMPLES = """examples:
  linkages bearing --diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000
  linkages bearing --diameter 80mm --length 40mm --clearance 0.1mm --viscosity 0.03 --speed 100 --load 1000 --film short
  linkages bearing --diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000 \
--groove angle=180deg,extent=20deg,length=0.8
"""
#: Values that the command needs: option, unit, meaning.
_NEEDED = (
    ("diameter", "m", "diameter of the bearing"),
    ("length", "m", "its length"),
    ("clearance", "m", "radial clearance"),
    ("speed", "rad/s", "angular velocity of the journal"),
    ("load", "N", "load on the journal"),
)
#: Keys of a groove, and their units (none of a pure number).
_GROOVE = {"angle": "rad", "extent": "rad", "length": "", "pressure": "Pa", "position": "", "shape": ""}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    for name, unit, meaning in _NEEDED:
        parser.add_argument(f"--{name}", required=True, metavar="VALUE", help=f"{meaning} [{unit}]")
    parser.add_argument("--viscosity", metavar="VALUE", help="dynamic viscosity [Pa s]")
    parser.add_argument("--grade", type=int, metavar="N", help="instead: ISO VG grade; a heat balance needs --inlet")
    parser.add_argument("--inlet", type=float, metavar="T", help="temperature of the oil that enters [degC]")
    parser.add_argument("--conductance", type=float, metavar="G", help="into the surroundings [W/K]")
    parser.add_argument("--surroundings", type=float, metavar="T", help="their temperature; default: inlet [degC]")
    parser.add_argument("--film", default="finite", metavar="NAME", help="film law; default: finite")
    rule = "guembel, reynolds or mass-conserving; default: the last with grooves or a cavity pressure, else the first"
    parser.add_argument("--cavitation", metavar="RULE", help=rule)
    groove = (
        '"angle = 90 deg, extent = 20 deg, length = 0.8": angle of its middle from the load, positive in the sense of'
        " rotation; length as a share of the bearing's, default 1; also position (share), pressure [Pa], shape = hole;"
        " may be repeated"
    )
    parser.add_argument("--groove", action="append", default=[], metavar="KEYS", help=groove)
    parser.add_argument("--supply-pressure", default="0", metavar="P", help="of the grooves, gauge; default: 0 [Pa]")
    parser.add_argument("--cavity-pressure", default="0", metavar="P", help="gauge, at most 0; default: 0 [Pa]")
    parser.add_argument("--tilt", default="0, 0", metavar="A, B", help="slope of the journal along and across the load")
    parser.add_argument("--mass", metavar="M", help="of the journal, for the threshold speed; default: load/g [kg]")
    add_units(parser)
    add_pictures(parser)
    add_out(parser)


def run(options: argparse.Namespace) -> int:
    """Compute the operating point; returns the exit status."""
    from linkages.explore.bearing import bearing, chart
    from linkages.explore.bearing_heat import warm_bearing
    from linkages.laws.film.surface.grooves import Groove
    from linkages.laws.heat import Heat

    supply = number("--supply-pressure", options.supply_pressure, "Pa")
    if supply and not options.groove:
        raise InputError("--supply-pressure", options.supply_pressure, "is the pressure of grooves; give --groove")
    grooves = [Groove(**_groove(text, supply)) for text in options.groove]
    tilt = [number("--tilt", part, "") for part in options.tilt.split(",")]
    if len(tilt) != 2:
        raise InputError("--tilt", options.tilt, 'give two slopes, such as "1e-4, 0"')
    values: dict[str, Any] = {name: number(f"--{name}", getattr(options, name), unit) for name, unit, _ in _NEEDED}
    out = output_folder(options, "bearing", "bearing")
    values |= {
        "film": options.film,
        "cavitation": options.cavitation,
        "grooves": grooves,
        "cavity_pressure": number("--cavity-pressure", options.cavity_pressure, "Pa"),
        "tilt": (tilt[0], tilt[1]),
        "mass": None if options.mass is None else number("--mass", options.mass, "kg"),
    }
    if (options.viscosity is None) == (options.grade is None):
        raise InputError("command line", "--viscosity", "give the viscosity, or --grade with --inlet")
    if options.grade is None:
        for name in ("inlet", "conductance", "surroundings"):
            if getattr(options, name) is not None:
                raise InputError(f"--{name}", f"{getattr(options, name):g}", "is for a heat balance; give --grade")
        point = bearing(**values, viscosity=number("--viscosity", options.viscosity, "Pa s"))
        content = point.content
    elif options.inlet is None:
        raise InputError("command line", "--inlet", "--grade needs the temperature of the oil that enters")
    else:
        heat = Heat(options.grade, options.inlet, options.conductance or 0.0, options.surroundings)
        warm = warm_bearing(heat, **values)
        point, content = warm.bearing, warm.content
    with out as folder:
        write_json(folder / "bearing.json", content)
        if not options.no_plots and point.film is not None:
            from linkages.show.plots.bearings import chart_figure, pressure_figure
            from linkages.show.plots.style import write_figure

            write_figure(pressure_figure(point), folder / "bearing_pressure")
            write_figure(chart_figure(point, chart(point.case, progress_bar("chart"))), folder / "bearing_chart")
        question = "Where does the journal settle under its load, and is this place stable?"
        from linkages.show.report.tables import bearing as tables_of

        table = format_bearing(point, content)
        record(
            options, folder, "Journal bearing", question, _answer(content), table, tables_of(content), _tiles(content)
        )
    print_results(options, table, out)
    return 0


def _answer(content: dict[str, Any]) -> list[str]:
    ratio, film = content["eccentricity_ratio"], 1e6 * content["least_film"]
    speed = content["threshold_speed"]
    stable = "stable at every speed" if speed is None else f"stable up to {speed:.4g} rad/s"
    return [
        f"The journal settles at {ratio:.4g} of the clearance from the centre; {film:.4g} µm of oil remain.",
        f"Friction takes {content['power']:.4g} W; a rigid journal is {stable}.",
    ]


def _tiles(content: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the numbers of the first screen, and their meanings."""
    from linkages.show.plots.quantities import quantity, share

    return [
        (share(content["eccentricity_ratio"]), "of the clearance: the journal's eccentricity"),
        (quantity(content["least_film"], "m", 3), "thinnest oil film"),
        (quantity(content["power"], "W", 3), "power of friction"),
    ]


def format_bearing(point: BearingPoint, content: dict[str, Any]) -> str:
    """Format an operating point as a table."""
    from linkages.show.plots.presentation import shown

    case = point.case
    rule = f", cavitation {content['cavitation']}" if content["cavitation"] else ""
    lines = [f"journal bearing, L/D {case.length / case.diameter:.4g}, {case.film} film{rule}", ""]

    def row(name: str, value: float | None, unit: str, none: str = "-") -> str:
        si, comma, more = unit.partition(",")
        label, factor = shown(si)
        return f"{name:24s}{none if value is None else f'{factor * value:.5g}':>14s}  {label}{comma}{more}"

    lines += [
        row("Sommerfeld number", content["sommerfeld"], "-"),
        row("eccentricity ratio", content["eccentricity_ratio"], "-"),
        row("attitude", math.degrees(content["attitude"]), "deg from the load to the eccentricity"),
        row("least film", content["least_film"], "m"),
        row("largest pressure", content["largest_pressure"], "Pa, gauge"),
        row("flow out of the ends", content["flow"], "m3/s"),
        *(row(f"flow of groove {k}", flow, "m3/s") for k, flow in enumerate(content["groove_flow"] or [], 1)),
        row("filling time", content["filling_time"], "s"),
        row("friction torque", content["friction_torque"], "N m"),
        row("power", content["power"], "W"),
        row("threshold speed", content["threshold_speed"], "rad/s, rigid journal", "stable"),
        row("critical mass", content["critical_mass"], "kg", "stable"),
    ]
    if "heat" in content:
        lines += [
            row("oil temperature", content["temperature"], "degC, lumped model"),
            row("viscosity", content["viscosity"], "Pa s"),
            row("heat by flow", content["heat"]["by_flow"], "W"),
            row("heat by conduction", content["heat"]["by_conduction"], "W"),
        ]
    lines += ["", f"{'':24s}{'along the load':>16s}{'across':>16s}"]
    for name, unit in (("stiffness", "N/m"), ("damping", "N s/m")):
        for k, values in enumerate(content[name]):
            label = f"{name} [{unit}]" if k == 0 else ""
            lines.append(f"{label:24s}" + "".join(f"{value:16.5g}" for value in values))
    return "\n".join(lines)


def _groove(text: str, supply: float) -> dict[str, Any]:
    """Read "angle = 90 deg, extent = 20 deg, length = 0.8"."""
    found: dict[str, Any] = {}
    for item in filter(None, map(str.strip, text.split(","))):
        key, equals, value = (part.strip() for part in item.partition("="))
        if key not in _GROOVE:
            raise InputError("--groove", key, f"unknown key; {nearest(key, _GROOVE)}")
        if not equals or not value:
            raise InputError("--groove", item, f"write {key} = VALUE")
        if key in found:
            raise InputError("--groove", key, "is given twice")
        found[key] = value if key == "shape" else number(f"--groove: {key}", value, _GROOVE[key])
    if missing := [key for key in ("angle", "extent") if key not in found]:
        raise InputError("--groove", missing[0], "is missing")
    shape = found.pop("shape", "groove")
    if shape not in ("groove", "hole"):
        raise InputError("--groove", "shape", f'"{shape}": must be groove or hole')
    return {"pressure": supply, "length": 1.0, **found, "hole": shape == "hole"}
