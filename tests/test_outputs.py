"""Named outputs mean the same wherever they are asked for."""

import numpy as np
import pytest

import linkages


def test_jitter_is_the_run_less_the_ideal_motion_in_sections_and_in_batches():
    """Peaks: of one revolution over continuous time, by a section and by the batch's own statistics."""
    name = "slider.vx"
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    section = linkages.stroboscopic(system, [name, f"{name}.jitter"], revolutions=1)
    ideal = linkages.ideal(system).evaluate(section.times)[name]
    np.testing.assert_allclose(section.strobe[f"{name}.jitter"], section.strobe[name] - ideal, rtol=1e-12)
    batch = linkages.simulate_batch(system, outputs=[f"{name}.jitter"], windows=[[0.0, section.period]])
    assert section.peaks(f"{name}.jitter")[0] == pytest.approx(batch.peak[0, 0, 0], rel=1e-6)
    assert batch.peak[0, 0, 0] > 0.1  # m/s: the linkage does rattle
