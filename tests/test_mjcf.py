"""Files of MuJoCo, imported: mass, degrees of freedom and motion as there."""

import re
import sys

import numpy as np
import pytest
from foreign_files import experiment, written
from mjcf_machines import CLOSED, CRANK, HEAD, OPEN, REFUSED, SLIDER_CRANK

from linkages import load_mechanism, simulate
from linkages.cli.main import main

TIME = 0.5


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
    model.opt.tolerance = 1e-12
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


@pytest.mark.slow
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


def test_included_files_and_what_is_left_out(taken, tmp_path):
    """A tendon may pull, so it is marked; a limit too; names that two parts have are told."""
    arm = CRANK.replace('name="O"', 'name="crank" range="-1 1"')
    (tmp_path / "arm.xml").write_text(f"<mujocoinclude>{arm}</body></mujocoinclude>")
    tendon = '<tendon><spatial name="rope" stiffness="3"><site site="a"/></spatial></tendon>'
    path, said, status = taken(HEAD + '<include file="arm.xml"/></worldbody>' + tendon + "</mujoco>")
    assert status == 0, said
    assert list(load_mechanism(path).joint) == ["crank_2"]
    assert "- joint crank has the name of another part: called crank_2" in said
    assert "changes the motion: <tendon_spatial> rope left out: it is unknown; check whether it moves" in said
    assert "changes the motion: <limit> of joint crank_2 left out: the other program stops the joint there" in said


def test_loops_close_without_mujoco(taken):
    """The slider-crank of the loop's test, in a quick test: three links, a loop, one degree of freedom."""
    rod = '<body name="rod" pos="0.1 0 0.05"><joint name="A" axis="0 1 0"/><geom fromto="0 0 0 0.3 0 -0.05" type="capsule"'
    text = HEAD + CRANK + rod + ' size="0.008"/></body></body>' + SLIDER_CRANK
    _, said, status = taken(text + '<connect body1="rod" body2="slider" anchor="0.3 0 -0.05"/></equality></mujoco>')
    assert status == 0, said
    assert "with 3 links, 4 joints, 1 loop, mobility 1" in said


XACRO = """<robot name="two" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="long" value="0.2"/>
<xacro:macro name="arm" params="name parent at"><link name="${name}"><inertial><origin xyz="${long / 2} 0 0"/>
<mass value="0.5"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="to_${name}" type="continuous"><parent link="${parent}"/><child link="${name}"/><axis xyz="0 0 1"/>
<origin xyz="${at} 0 0"/></joint></xacro:macro><link name="world"/><xacro:arm name="a" parent="world" at="0"/>
<xacro:arm name="b" parent="a" at="${long}"/></robot>"""


def test_xacro_is_expanded(taken):
    pytest.importorskip("xacro", reason="xacro is not installed")
    path, said, status = taken(XACRO)
    assert status == 0, said
    assert load_mechanism(path).joint["to_b"].on_parent.tolist() == [0.2, 0.0]


def test_xacro_without_its_package_is_refused_in_one_line(taken, monkeypatch):
    monkeypatch.setitem(sys.modules, "xacro", None)
    _, said, status = taken(XACRO)
    install = 'pip install "linkages[import]"; or run `xacro FILE > NAME.urdf` elsewhere'
    assert (said, status) == (f"error: theirs.xml: is xacro: needs the package of that name: {install}\n", 2)


@pytest.mark.parametrize(("name", "text", "said"), [
    ("a.slx", "PK", "a.slx: is a Simulink model; SDFormat (<sdf>), URDF and xacro (<robot>) and MJCF (<mujoco>) are read"),
    ("a.xml", "<OpenSimDocument/>", "a.xml: <OpenSimDocument>: is an OpenSim model; SDFormat"),
    ("a.xml", "<tree/>", "a.xml: <tree>: is of an unknown format; SDFormat"),
])  # fmt: skip
def test_other_formats_are_named(tmp_path, capsys, name, text, said):
    (tmp_path / name).write_text(text)
    assert main(["import", str(tmp_path / name), "--out", str(tmp_path / "out.sdf")]) == 2
    assert capsys.readouterr().err.startswith(f"error: {said}")
