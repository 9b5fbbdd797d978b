"""Content of ``wear.json``."""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.explore.wear.stages import SIDES, Life
from linkages.input.files.versions import versions
from linkages.results.outputs.registry import unit


def content(life: Life) -> dict[str, Any]:
    """Make the content of ``wear.json``: final wear, and all stages, in SI units.

    ``joints`` by name: ``volume`` [m3], largest ``depth`` [m], ``play`` [m] (mean radial clearance), ``load_distance``,
    the integral of N |v_t| dt [N m], ``coefficient`` [m2/N], and for `bearing` and `journal` their parts with
    ``profile``, pairs of angle [rad] and depth [m]; ``profile`` of the joint belongs to the wearing part (to the
    bearing if both wear). ``blocks`` has an entry for each stage: ``cycles``, ``error`` of the depth in the jump [m],
    measured work per cycle, volumes, depths, clearances, profiles; ``peaks`` at the cycle ``middle``, in the ``units``.
    """
    joints = {joint.name: _joint(life, joint.name, -1) for joint in life.joints}
    blocks = []
    for k, stage in enumerate(life.stages):
        measured = {}
        for name, work in stage.block.work.items():
            deviation = float(np.std(work, ddof=1)) if len(work) > 1 else None
            measured[name] = {"cycles": len(work), "work": float(work.mean()), "deviation": deviation}
        blocks.append(
            {
                "cycles": stage.cycles,
                "middle": stage.middle,
                "error": stage.error,
                "simulated": stage.block.cycles,
                "measured": measured,
                "peaks": stage.block.peaks,
                "joints": {name: _joint(life, name, k) for name in joints},
            }
        )
    return {
        "cycles": int(life.cycles[-1]),
        "status": life.status.value,
        "joints": joints,
        "units": {name: unit(life.system, name) for name in life.stages[0].block.peaks},
        "blocks": blocks,
        "simulated_cycles": life.simulated,
        "rejected_jumps": life.rejected,
        "tolerance": life.tolerance,
        "scatter": life.scatter,
        "title": life.system.experiment.title,
        "experiment": life.system.experiment.source.name,
        "provenance": {"versions": versions()},
    }


def _joint(life: Life, name: str, k: int) -> dict[str, Any]:
    """Describe the wear of a joint at a stage."""
    profiles, volumes = life.profiles(name)[k], life.volumes(name)[k]
    owner = next(joint for joint in life.joints if joint.name == name)
    angles = 2.0 * np.pi * np.arange(profiles.shape[1]) / profiles.shape[1]
    parts = {
        side: {
            "coefficient": coefficient,
            "volume": float(volume),
            "depth": float(profile.max()),
            "profile": np.column_stack([angles, profile]).tolist(),
        }
        for side, coefficient, volume, profile in zip(SIDES, owner.coefficients, volumes, profiles, strict=True)
        if coefficient > 0.0 or profile.any()
    }
    return {
        "volume": float(volumes.sum()),
        "depth": float(profiles.max()),
        "play": float(life.play(name)[k]),
        "clearance": owner.clearance,
        "radius": owner.radius,
        "coefficient": sum(owner.coefficients),
        "load_distance": life.stages[k].work[name],
        "profile": next(iter(parts.values()))["profile"],
        **parts,
    }
