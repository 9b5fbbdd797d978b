"""The animation of a run: Meshcat's recording where Drake is installed, else the moved drawing."""

from __future__ import annotations

from pathlib import Path

from linkages.base.packages import check_installed, installed
from linkages.results.assessment import Assessment


def write_animation(assessment: Assessment, path: Path, exaggerate: float | None = None) -> None:
    """Write the run as an animation, an HTML file.

    `exaggerate` is a factor on the journals' eccentricities and on the deflections of flexible links; default: true
    eccentricities, and deflections magnified until visible. The linkage is assembled again at each frame with its drive
    positions, magnified eccentricities and magnified deflections. ValueError if it cannot be assembled with these
    offsets, or its drives do not determine its motion. Without Drake the drawing moves, its joints are not magnified,
    and `exaggerate` is an InputError.
    """
    check_animation(exaggerate)
    if installed("pydrake"):
        from linkages.show.plots.animation.recording import write_recording

        write_recording(assessment, path, exaggerate)
    else:
        from linkages.show.plots.drawing.replay import write_replay

        write_replay(assessment.system, assessment.run, path)


def check_animation(exaggerate: float | None) -> None:
    """Raise an InputError if this environment cannot draw an exaggerated animation."""
    if exaggerate is not None:
        check_installed("pydrake", "--exaggerate")
