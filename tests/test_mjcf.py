"""Files of MuJoCo, imported: mass, degrees of freedom and motion as there."""

import re

import numpy as np
import pytest
from foreign_files import experiment, written
from mjcf_machines import CLOSED, CRANK, HEAD, OPEN, REFUSED

from linkages import load_mechanism, simulate
from linkages.cli.main import main

TIME = 0.5
NO_COLLISIONS = '<default><geom contype="0" conaffinity="0"/></default>'


@pytest.fixture
def taken(tmp_path, capsys):
    """Import a text; returns the path of the machine's file, the lines that were printed, and the status."""

    def taken(text):
        source, out = tmp_path / "theirs.xml", tmp_path / "ours.sdf"
        source.write_text(text)
        status = main(["import", str(source), "--out", str(out)])
        told = capsys.readouterr()
        return out, told.out + told.err, status

    return taken


def there(text, times, step=1e-4):
    """Mass of the moving bodies [kg], and joint coordinates from the reference pose at times, by MuJoCo."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, step
    model.opt.iterations, model.opt.tolerance = 200, 0.0
    data, found = mujoco.MjData(model), {model.joint(k).name: [] for k in range(model.njnt)}
    for time in times:
        while data.time < time - 0.5 * step:
            mujoco.mj_step(model, data)
        for k in range(model.njnt):
            at = model.jnt_qposadr[k]
            found[model.joint(k).name].append(data.qpos[at] - model.qpos0[at])
    weld = model.body_weldid
    return sum(m for k, m in enumerate(model.body_mass) if weld[k]), {name: np.array(q) for name, q in found.items()}


def here(path, said):
    """Run of an imported machine, with what the import prints for the experiment."""
    gravity = re.search(r"gravity = \[.*\]", said)[0]
    return simulate(experiment(path, f"{gravity}\n{written(said)}", TIME))


@pytest.mark.parametrize(("text", "mass", "freedom"), OPEN.values(), ids=OPEN)
def test_a_tree_moves_as_in_mujoco(taken, text, mass, freedom):
    path, said, status = taken(text)
    assert status == 0, said
    assert re.search(rf"mobility {freedom}\b", said), said
    times = np.linspace(0.1, TIME, 5)
    whole, theirs = there(text, times)
    assert sum(link.mass for link in load_mechanism(path).links) == pytest.approx(whole, rel=1e-12)
    assert mass is None or whole == pytest.approx(mass)
    run = here(path, said).evaluate(times)
    assert max(np.abs(q).max() for q in theirs.values()) > 0.01
    for name, q in theirs.items():
        np.testing.assert_allclose(run[f"q.{name}"], q, atol=1e-6, err_msg=name)


@pytest.mark.parametrize(("text", "mass", "freedom"), CLOSED.values(), ids=CLOSED)
def test_a_loop_moves_as_in_mujoco(taken, text, mass, freedom):
    path, said, status = taken(text)
    assert status == 0, said
    assert re.search(rf"mobility {freedom}\b", said), said
    times = np.linspace(0.1, TIME, 5)
    whole, theirs = there(text, times, step=1e-5)
    assert sum(link.mass for link in load_mechanism(path).links) == pytest.approx(whole, rel=1e-12)
    assert mass is None or whole == pytest.approx(mass)
    run = here(path, said).evaluate(times)
    for name, q in theirs.items():
        if f"q.{name}" in run:
            np.testing.assert_allclose(run[f"q.{name}"], q, atol=1e-6, err_msg=name)


@pytest.mark.parametrize(("text", "said"), REFUSED.values(), ids=REFUSED)
def test_a_file_that_no_planar_linkage_has_is_refused(taken, text, said):
    path, told, status = taken(text)
    assert status == 2
    assert len(told.splitlines()) == 1
    assert said in told
    assert not path.exists()
