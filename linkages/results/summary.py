"""The summary of a run: extremes of its outputs and of the ideal linkage's, with errors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from linkages.arguments import validated
from linkages.brief import Brief
from linkages.errors import Status
from linkages.files.versions import versions
from linkages.planar.arrays import Arrays
from linkages.planar.record_types import STOP
from linkages.results.characteristics import effort_of, link_columns, numbers, peaks_by_key
from linkages.results.divergence import apart
from linkages.results.film_heat import JointHeat, heat_warnings
from linkages.results.impacts import Impact, impacts
from linkages.results.indeterminate import indeterminate
from linkages.results.joint_validity import outside
from linkages.results.noise import noise
from linkages.results.peak_errors import errors
from linkages.results.singular import Passage, passages
from linkages.results.startup import startup_end
from linkages.results.steady_state import Motion, motion_of
from linkages.results.trajectory import Trajectory
from linkages.results.warnings import chaotic, geared, meaningless, rough, singular, undetermined, unstretched
from linkages.system import System
from linkages.system.rigid_segments import system_of

_COMPARED = 500  # number of times at which the run and the tighter one are compared


@dataclass(frozen=True, repr=False)
class Study(Brief):
    """A run with its ideal linkage and a run at a tighter tolerance; made by `linkages.study`.

    Attributes
    ----------
    system : System
    engine : str
        Engine of the run.
    run : Trajectory
    ideal : Trajectory
        Motion of the linkage with every joint ideal and every link rigid; see `linkages.ideal`.
    tighter : Trajectory or None
        The run repeated at a ten times tighter tolerance.
    heat : dict of str to JointHeat
        Heat balances of the joints that have one, by name.
    """

    system: System
    engine: str
    run: Trajectory
    ideal: Trajectory
    tighter: Trajectory | None
    heat: dict[str, JointHeat] = field(default_factory=dict)

    def _facts(self) -> tuple[str, dict[str, str]]:
        title = self.system.experiment.title or self.system.experiment.source.stem
        parts = {"run": self.run, "ideal": self.ideal, "tighter": self.tighter}
        rows = {name: part._facts()[0] if part is not None else "not computed" for name, part in parts.items()}
        return f"{title}; {self.engine} engine, {self.run.status.value}", rows

    @cached_property
    def contacts(self) -> list[Impact]:
        """Return all contacts of the run."""
        return impacts(self.run, touching(self.system))

    @cached_property
    def motion(self) -> Motion:
        """Classify the motion at the end of the run."""
        return motion_of(self.system, self.run)

    @cached_property
    def start_up(self) -> float | None:
        """Return the end of the start-up of clearance joints [s]; None if no journal starts with free flight."""
        return startup_end(self.system, self.contacts, self.run, self.ideal)

    @cached_property
    def windows(self) -> dict[str, tuple[float, float]]:
        """Return the time ranges with separate results, by name [s]; docs/outputs.md lists them."""
        experiment, end = self.system.experiment, float(self.run.time[-1])
        asked = {name: (window.start, window.end) for name, window in experiment.windows.items()}
        if experiment.report_from is not None:
            asked["report"] = experiment.report_from, experiment.duration
        if self.motion.cycle is not None:
            asked["steady"] = self.motion.cycle
        elif self.start_up is not None:
            asked["later"] = self.start_up, end
        return {name: (start, min(stop, end)) for name, (start, stop) in asked.items() if start < end}

    @property
    def reported(self) -> str:
        """Return the name of the window that tables show first, or "whole"."""
        experiment = self.system.experiment
        if experiment.report == "whole" and experiment.report_from is None:
            return "whole"
        wanted = ("report",) if experiment.report_from is not None else ("steady", "later")
        return next((name for name in wanted if name in self.windows), "whole")

    @cached_property
    def passages(self) -> list[Passage]:
        """Return the singular positions of the closed loops on or near the run."""
        return passages(self._model.tree, self._model.arrays, self.run)

    @cached_property
    def ideal_passages(self) -> list[Passage]:
        """Return the singular positions on or near the motion with ideal joints."""
        system, arrays = self._ideal_model
        return passages(system.tree, arrays, self.ideal)

    @cached_property
    def indeterminate(self) -> tuple[str, ...]:
        """Return the statically indeterminate columns of the run."""
        return indeterminate(self._model, self._model.arrays, self.run)

    @cached_property
    def ideal_indeterminate(self) -> tuple[str, ...]:
        """Return the statically indeterminate columns of the motion with ideal joints."""
        return indeterminate(*self._ideal_model, self.ideal)

    @cached_property
    def meaningless(self) -> frozenset[str]:
        """Return the columns of the run with meaningless peaks."""
        return meaningless(_judged(self.system), self.passages, self.indeterminate, self.system.experiment.drives)

    @cached_property
    def _model(self) -> System:
        """Return the system with the run's coordinates."""
        return system_of(self.system, self.run.columns)

    @cached_property
    def _ideal_model(self) -> tuple[System, Arrays]:
        """Return the system with the ideal motion's coordinates, and its arrays."""
        if self.system.determinate:
            return self.system, self.system.ideal_arrays
        system = self.system.ideal()
        return system, system.arrays

    @cached_property
    def noise(self) -> dict[str, float]:
        """Return the rounding level of the run's columns."""
        return noise(self.system, [name for name in self.run.columns if name != "time"])

    @cached_property
    def apart(self) -> tuple[float, float] | None:
        """Return the times of divergence and final convergence of the run and the tighter one [s], or None."""
        run, tighter = self.run, self.tighter
        if tighter is None or run.evaluate is None:
            return None
        return apart(run, tighter, self.system, 1 + len(tighter.time) // _COMPARED)


@validated
def summarize(study: Study) -> dict[str, Any]:
    """Make the contents of ``summary.json`` in SI units; see docs/outputs.md.

    Parameters
    ----------
    study : Study
        From `linkages.study`.

    Returns
    -------
    dict
        Numbers, texts, lists and dicts, ready for JSON.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> summary = linkages.summarize(linkages.study(system, "compiled"))
    >>> summary["status"], round(summary["joints"]["A"]["force"]["peak"], 2)
    ('ok', 3.32)
    """
    summary = unjudged(study)
    return summary | judge(study, summary)


def unjudged(study: Study) -> dict[str, Any]:
    """Make the contents of ``summary.json`` without errors and warnings, which `judge` adds."""
    system, tree = study.system, study.system.tree
    quality = system.assembly.quality
    whole = numbers(system, study.run, study.meaningless, study.contacts)
    for name, heat in study.heat.items():
        whole["joints"][name]["heat"] = heat.content
    ideal = numbers(system, study.ideal, _ideal_meaningless(study))
    windows = {name: _window(study, span, ideal) for name, span in study.windows.items()}
    motion = study.motion
    return {
        "engine": study.engine,
        "duration": float(study.run.time[-1]),
        "status": study.run.status.value,
        "mechanism": {
            "name": system.mechanism.name,
            "mobility": system.assembly.mobility,
            "driven": [*tree.driven, *tree.powered],
            "joints": {joint.name: [joint.parent, joint.child] for joint in system.mechanism.joints},
            "cut": {"play": list(tree.play), "ideal": list(tree.loops)},
            "quality": None if np.isnan(quality) else quality,
            "loop_error": study.run.provenance.get("loop_error", 0.0),
        },
        **whole,
        "ideal": {"status": study.ideal.status.value, **ideal},
        "motion": {key: getattr(motion, key) for key in ("kind", "why", "period", "periods", "since")},
        "start_up": study.start_up,
        "report": study.reported,
        "error": {},
        "warnings": [],
        "windows": windows,
        "provenance": {
            "versions": versions(),
            "experiment": system.experiment.model_dump(exclude_unset=True, exclude_none=True)
            | {"file": system.experiment.source.name},
            "sources": system.experiment.sources,
            "run": {key: value for key, value in study.run.provenance.items() if key != "wall_time"},
            "wall_time": study.run.provenance["wall_time"],
        },
    }


def _ideal_meaningless(study: Study) -> frozenset[str]:
    """Return the columns of the motion with ideal joints that have meaningless peaks."""
    drives = study.system.experiment.drives
    return meaningless(_judged(study.system), study.ideal_passages, study.ideal_indeterminate, drives)


def _window(study: Study, span: tuple[float, float], ideal: dict[str, Any]) -> dict[str, Any]:
    """Collect the numbers of a time range, with ideal joints (whole motion if that ends earlier)."""
    system = study.system
    found = numbers(system, study.run.within(*span), study.meaningless, study.contacts)
    if study.ideal.time[-1] >= span[1]:
        ideal = numbers(system, study.ideal.within(*span), _ideal_meaningless(study))
    return {"from": span[0], "to": span[1], **found, "ideal": ideal}


def judge(study: Study, whole: dict[str, Any]) -> dict[str, Any]:
    """Make ``error`` and ``warnings`` of a summary.

    Parameters
    ----------
    study : Study
    whole : dict
        Result of `unjudged` or `summarize` for the same run.

    Returns
    -------
    dict
        ``error`` has the error of each peak by the peak's key (``slider7.ax.peak``), None without an estimate, and
        is empty without a tighter run; see `linkages.results.peak_errors`. ``windows`` are the windows of ``whole``
        with their errors.
    """
    peaks, error = peaks_by_key(whole), _errors(study, study.run, study.tighter, whole)
    estimated = study.tighter is not None and study.tighter.status is Status.OK
    unknown = [key for key in error if estimated and error[key] is None and peaks[key] is not None]
    found = [
        *singular(study.passages, study.ideal_passages),
        *undetermined(study.indeterminate, study.ideal_indeterminate),
        *rough(study.tighter, peaks, error, study.noise),
        *chaotic(study.apart, unknown),
        *outside(study.system, study.run, study.contacts),
        *unstretched(study.system, study.run),
        *geared(study.system),
        *heat_warnings(study.heat),
    ]
    judged: dict[str, Any] = {"error": error, "warnings": found, "windows": {}}
    for name, window in whole.get("windows", {}).items():
        span, tighter = (window["from"], window["to"]), study.tighter
        if tighter is not None and tighter.time[-1] >= span[1]:
            tighter = tighter.within(*span)
        judged["windows"][name] = window | {"error": _errors(study, study.run.within(*span), tighter, window)}
    return judged


def _errors(
    study: Study, run: Trajectory, tighter: Trajectory | None, of: Mapping[str, Any]
) -> dict[str, float | None]:
    """Estimate the error of each peak of a run or a part of it; empty without the tighter run."""
    if tighter is None:
        return {}
    peaks = peaks_by_key(of)
    if tighter.status is not Status.OK:
        return dict.fromkeys(peaks)
    finer = peaks_by_key(numbers(study.system, tighter, study.meaningless))
    return errors(run, tighter, peaks, finer, study.apart, study.noise)


def meaningless_of(system: System, run: Trajectory, names: Iterable[str]) -> frozenset[str]:
    """Select the meaningless columns of one run, see `linkages.results.warnings.meaningless`."""
    moved = system_of(system, run.columns)
    found = passages(moved.tree, moved.arrays, run), indeterminate(moved, moved.arrays, run)
    return meaningless(names, *found, system.experiment.drives) & frozenset(names)


def warnings_of(system: System, run: Trajectory, contacts: Sequence[Impact]) -> list[dict[str, Any]]:
    """List warnings of one run: singular positions, indeterminate forces, laws outside their validity."""
    moved = system_of(system, run.columns)
    return [
        *singular(passages(moved.tree, moved.arrays, run), ()),
        *undetermined(indeterminate(moved, moved.arrays, run), ()),
        *outside(system, run, contacts),
    ]


def touching(system: System) -> list[str]:
    """Return the contacts that can touch: joints, corners of guides, prismatic stops, points at lines."""
    turning = system.ends["kind"] == STOP  # revolute stops give a torque
    able = system.touching & ~turning
    return [label for (_, label), one in zip(system.contacts, able, strict=True) if one]


def _judged(system: System) -> list[str]:
    """Return the columns of outputs, joint forces, torques of drives and gears, and of flexible links."""
    experiment = system.experiment
    forces = [f"{joint.name}.force" for joint in system.mechanism.joints]
    gears = [f"{name}.{effort_of(system, 'gears', name)}" for name in experiment.gears]
    links = [column for name in experiment.flexible for column in link_columns(name)]
    return [*experiment.outputs, *forces, *(f"{name}.torque" for name in experiment.drives), *gears, *links]
