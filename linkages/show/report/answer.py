"""The question of a run, and its answer in three sentences: the action of the joints, its effect, a proposal."""

from __future__ import annotations

import shlex
from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from linkages.base.errors import Status, listed
from linkages.input.files.magnitudes import rounded
from linkages.input.files.toml import leaves
from linkages.results.shape import peaks_by_key
from linkages.results.warnings import relative
from linkages.show.plots.quantities import change, quantity, share
from linkages.show.plots.style import engineering
from linkages.show.report import words
from linkages.show.report.result_folder import Results
from linkages.show.report.units import output_unit

_MODELS = {"dry": "dry", "lubricated": "lubricated", "mixed": "film and contact"}
_SAME = 1e-4  # relative change that is neglected
_MANIFOLD = 2.0  # ratio from which a change is a multiple
_DEEP = 0.8  # eccentricity ratio from which a film has little reserve


def question(results: Results) -> str:
    """Write the question of the run in one sentence."""
    alike: dict[tuple[str, float], list[str]] = defaultdict(list)
    for name, joint in results.play.items():
        alike[joint["model"], joint["clearance"]].append(name)
    if not alike:
        return "How does this linkage move with ideal joints, and what forces pass through them?"
    play = listed(
        f"{1e3 * clearance:.4g} mm of clearance in joint{'s'[: len(names) > 1]} {listed(names)} ({_MODELS[model]})"
        for (model, clearance), names in alike.items()
    )
    if results.summary["ideal"] is None:
        return f"How does this linkage move with {play}, and what forces pass through its joints?"
    return (
        f"How does this linkage move with {play}, what forces pass through its joints,"
        " and how does this differ from the linkage with ideal joints?"
    )


def answer(summary: dict[str, Any], file: str) -> list[str]:
    """Answer the question of a run of an experiment's file in three sentences; a first one if it ended early."""
    shown = words.reported(summary)
    play = {name: joint for name, joint in shown["joints"].items() if "eccentricity_ratio" in joint}
    loose = {name: load for name, load in shown.get("loads", {}).items() if "impacts" in load}
    status = Status(summary["status"])
    if status is Status.OK:
        return [_action(play, loose), _effect(shown, summary["warnings"]), _trial(play, summary, file)]
    asked = f"{summary['duration']:.4g} s of {summary['provenance']['experiment']['duration']:g} s"
    ended = f"The run ended early, at {asked}, with the status {status.value}; the numbers belong to this part."
    return [ended, _action(play, loose), _effect(shown, summary["warnings"]), f"Next, {status.remedy}."]


def tiles(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the four numbers of the first screen, each with its meaning."""
    shown, ideal = words.reported(summary), words.perfect(words.reported(summary))
    found = []
    forces = {name: joint["force"]["peak"] for name, joint in shown["joints"].items() if joint["force"]["peak"]}
    if forces:
        name = max(forces, key=forces.__getitem__)
        told = change(forces[name], ideal["joints"][name]["force"]["peak"] or 0.0)
        found.append((quantity(forces[name], "N"), f"largest joint force, in {name}" + (f"; {told}" if told else "")))
    else:
        found += _effort_tiles(shown)
    films = {
        name: joint["film_thickness"]["min"] for name, joint in shown["joints"].items() if "film_thickness" in joint
    }
    contact = {
        f"{kind}{name}": one["contact_fraction"]
        for kind, place in (("joint ", "joints"), ("flanks of ", "loads"))
        for name, one in shown.get(place, {}).items()
        if one.get("contact_fraction")
    }
    if contact:
        name = max(contact, key=contact.__getitem__)
        found.append((share(contact[name]), f"of the time in contact, {name}"))
    elif films:
        name = min(films, key=films.__getitem__)
        found.append((quantity(films[name], "m", 3), f"thinnest oil film, in {name}"))
    kind = (summary.get("motion") or {}).get("kind")
    found.append((kind or summary["status"], "motion at the end of the run" if kind else "status of the run"))
    peaks = peaks_by_key(summary)
    estimated = {key: error for key, error in summary["error"].items() if key in peaks}
    errors = [part for _, part in relative(peaks, estimated) if part < 1.0]
    if errors:
        found.append((share(max(errors[0], 1e-4)), "largest error of a peak, estimated"))
    return found


def _effort_tiles(shown: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the largest torque or force of loads, else of drives, of a machine whose joints carry no force."""
    for kind in ("loads", "drives"):
        acting = [row for row in words.effort_rows(shown, kind) if row[2]["peak"]]
        if acting:
            label, _, value, exact, si = max(acting, key=lambda row: row[2]["peak"])
            owner, _, effort = label.rpartition(" ")
            told = change(value["peak"], exact["peak"] or 0.0)
            meaning = f"largest {effort}, of {owner}" + (f"; {told}" if told not in ("", "as ideal") else "")
            return [(quantity(value["peak"], si), meaning)]
    return []


def remarks(summary: dict[str, Any]) -> list[str]:
    """Write warnings, outputs without a peak, the final motion and signals from data files, a sentence each."""
    found = [f"{entry['what']}; {entry['remedy']}" for entry in summary.get("warnings", ())]
    outputs = {name: value["peak"] for name, value in words.reported(summary)["outputs"].items()}
    found += [f"the output {name} {words.reason(summary['warnings'])}" for name in words.unknown(outputs)]
    signals = *words.recorded_lines(summary), *words.smoothing_lines(summary)
    return [_sentence(line) for line in (*found, *words.motion_lines(summary), *signals)]


def _action(play: dict[str, Any], loose: dict[str, Any]) -> str:
    """Tell how the joints with clearance work, on a film, in contact, or neither, and the flanks of loose couplings."""
    touching = {name: joint for name, joint in play.items() if joint["impacts"] or joint["contact_fraction"]}
    riding = {name: joint for name, joint in play.items() if name not in touching and "film_thickness" in joint}
    free = [name for name in play if name not in touching | riding]
    said = [_riding(riding)] if riding else []
    for name, joint in touching.items():
        times, part = _times(joint["impacts"]), words.percent(joint["contact_fraction"])
        said.append(f"joint {name} touches {times} and is in contact for {part} of the time")
    if free:
        said.append(f"joint{'s'[: len(free) > 1]} {listed(free)} {'do' if len(free) > 1 else 'does'} not touch")
    said += [] if play else ["all joints are ideal"]
    for name, load in loose.items():
        times, part = _times(load["impacts"]), words.percent(load["contact_fraction"])
        said.append(f"the flanks of {name} touch {times} and are in contact for {part} of the time")
    return _sentence("; ".join(said))


def _riding(joints: dict[str, Any]) -> str:
    """Describe joints whose films carry their journals."""
    what = (
        f"oil films carry joints {listed(joints)}" if len(joints) > 1 else f"an oil film carries joint {listed(joints)}"
    )
    used = words.percent(max(joint["eccentricity_ratio"]["peak"] for joint in joints.values()))
    least = _measured(min(joint["film_thickness"]["min"] for joint in joints.values()), "m")
    return f"{what}: a journal moves up to {used} of the clearance from the centre, and {least} of oil remain"


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _effect(shown: dict[str, Any], warned: Sequence[dict[str, Any]]) -> str:
    """Tell the effect of clearance: the first output, the output whose peak changes most, and the largest force.

    Forces without a value are named, with the reason that the run's warnings give.
    """
    said, ideal = [], words.perfect(shown)
    for name in [*shown.get("difference", {})][:1]:
        largest, part = shown["difference"][name]["peak"], words.percent(shown["difference"][name]["share"])
        of = "" if part == "-" else f" ({part} of its range)" if part.endswith("%") else f" ({part} its range)"
        said.append(f"{name} differs by up to {_measured(largest, output_unit(name, shown['drives']))}{of}")
    peaks = {
        name: (value["peak"], ideal["outputs"][name]["peak"])
        for name, value in shown["outputs"].items()
        if value["peak"] is not None
    }
    known = {name: real / exact for name, (real, exact) in peaks.items() if exact and exact > words.NOTHING * real}
    if said and known:
        name = max(known, key=lambda name: abs(known[name] - 1.0))
        said.append(f"the peak of {name} is {_changed(known[name])}")
    every = {name: joint["force"]["peak"] for name, joint in shown["joints"].items()}
    forces, unknown = {name: peak for name, peak in every.items() if peak is not None}, words.unknown(every)
    if any(forces.values()):
        name = max(forces, key=forces.__getitem__)
        exact = ideal["joints"][name]["force"]["peak"] if said else None
        beside = f", {_changed(forces[name] / exact)}" if exact else ""
        which = "largest known joint force" if unknown else "largest joint force"
        said.append(f"the {which} is {_measured(forces[name], 'N')}, in {name}{beside}")
    lead = "compared with ideal joints, " if shown.get("difference") else ""
    told = [f"{lead}{listed(said)}"] if said else []
    if unknown:
        told.append(f"the force{'s'[: len(unknown) > 1]} in {words.some(unknown)} {words.reason(warned, len(unknown))}")
    told += [] if unknown or any(every.values()) else _unloaded(shown, warned)
    return _sentence("; ".join(told))


def _unloaded(shown: dict[str, Any], warned: Sequence[dict[str, Any]]) -> list[str]:
    """Tell what moves a machine whose joints carry no force: the largest torques and forces of loads and drives."""
    largest: dict[tuple[str, str], tuple[str, float, float]] = {}
    for kind in ("loads", "drives"):
        for label, _, value, exact, si in words.effort_rows(shown, kind):
            if (value["peak"] or 0.0) > largest.get((kind, si), ("", 0.0, 0.0))[1]:
                largest[kind, si] = label, value["peak"], exact["peak"] or 0.0
    told = list[str]()
    for (kind, si), (label, most, rigid) in largest.items():
        owner, _, effort = label.rpartition(" ")
        ratio = f", {_changed(most / rigid)}" if rigid and abs(most / rigid - 1.0) >= _SAME else ""
        told.append(f"the largest {effort} of the {kind} is {_measured(most, si)}, of {owner}{ratio}")
    if any(one["kind"] == "gear" for one in warned):
        return ["the joints carry no force but those of teeth or belts, which are not computed", *told]
    moving = {name: value["peak"] for name, value in shown["outputs"].items() if value["peak"]}
    reached = [f"{name} reaches {_measured(peak, output_unit(name, shown['drives']))}" for name, peak in moving.items()]
    return [
        f"no force passes through the joints{'' if told else ', and no load or drive acts'}",
        *(told or reached[:2]),
    ]


def _changed(ratio: float) -> str:
    """Compare a peak with the one of ideal joints."""
    if abs(ratio - 1.0) < _SAME:
        return "the same"
    if ratio >= _MANIFOLD:
        return f"{ratio:.3g} times as large"
    return f"{words.percent(abs(ratio - 1.0))} {'larger' if ratio > 1.0 else 'smaller'}"


def _trial(play: dict[str, Any], summary: dict[str, Any], file: str) -> str:
    """Propose the next run: less clearance against impacts; a thinner film if it has a reserve, otherwise a thicker."""
    joints = summary["provenance"]["experiment"].get("joints", {})
    given = {name: joint for name, joint in play.items() if name in joints}
    if not given:
        return _trial_of_backlash(summary, file) or 'Try clearance in a joint: "linkages keys joints" lists its keys.'
    name = max(given, key=lambda name: given[name]["eccentricity_ratio"]["peak"])
    joint, values = given[name], joints[name]

    def setting(key: str, factor: float) -> str:
        value = float(rounded(factor * values[key]))
        return shlex.join(words.simulation(summary, file, {f"joints.{name}.{key}": value}))

    if joint["impacts"] or "film_thickness" not in joint:
        return f"Try half of this clearance: {setting('clearance', 0.5)}"
    deep = joint["eccentricity_ratio"]["peak"] >= _DEEP
    reserve = f"The film of joint {name} has {'little' if deep else 'a'} reserve: try"
    if "viscosity" in values:
        return f"{reserve} {'thicker' if deep else 'thinner'} oil: {setting('viscosity', 2.0 if deep else 0.5)}"
    return f"{reserve} {'less' if deep else 'more'} clearance: {setting('clearance', 0.5 if deep else 2.0)}"


def _trial_of_backlash(summary: dict[str, Any], file: str) -> str:
    """Propose half of the first backlash; empty without one."""
    for path, value in leaves(summary["provenance"]["experiment"]):
        if path.endswith((".backlash.normal", ".backlash.play")):
            half = float(rounded(0.5 * value))
            return f"Try half of this backlash: {shlex.join(words.simulation(summary, file, {path: half}))}"
    return ""


def _measured(value: float, si: str) -> str:
    """Write a value with its most readable unit: "0.165 mm"."""
    unit, factor = engineering(si, abs(value))
    return f"{rounded(factor * value)} {unit}".rstrip()


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."
