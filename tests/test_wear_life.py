"""Wear over a life: jumps, blocks that are kept, the command."""

import json
import math
import os
import signal

import numpy as np
import pytest
from machines import joint, solid
from processes import finish, start
from wearing_press import CLEARANCE, FORCE, LENGTH, RADIUS, SDF, SPRING, crescent, write_press

import linkages
from linkages.cli.main import main
from linkages.explore.wear.block_store import BlockStore
from linkages.explore.wear.life import wear_life
from linkages.explore.wear.measure import BlockStart, CycleBlock, _settled, depths_of, wearing
from linkages.explore.wear.stages import content, worn
from linkages.input.model.check import DEEPEST
from linkages.laws.wear.profile import node_depths
from linkages.show.report.page_tables import number


@pytest.fixture
def press(tmp_path):
    def made(load=FORCE, **values):
        path = write_press(tmp_path, load)
        return linkages.load(path, {f"joints.B.{key}": value for key, value in values.items()})

    return made


def fitted_half_angle(profile, about):
    """Half-angle where the line through depth over cosine, most of the pocket, is zero [rad]."""
    phi = 2.0 * np.pi * np.arange(len(profile)) / len(profile) - about
    deep = profile > 0.1 * profile.max()
    slope, offset = np.polyfit(np.cos(phi[deep]), profile[deep], 1)
    return math.acos(-offset / slope)


def test_outputs_without_jitter_are_watched_themselves():
    """The peak of a cycle is the stress of a flexible rod, and the jitter of a point."""
    dry = {"model": "dry", "clearance": 5e-5, "wear": {"coefficient": 1e-15}}
    contact = {"law": "lankarani-nikravesh", "restitution": 0.9, "youngs_modulus": 207e9}
    overrides = {"joints.B": dry | {"contact": contact}, "outputs": ["slider.x", "rod.stress", "rod_mid.deflection"]}
    system = linkages.load(linkages.find_file("slider_crank_flexible.toml"), overrides)
    peaks = wear_life(system, 2).stages[0].block.peaks
    assert list(peaks) == ["B.force", "O.torque", "slider.x.jitter", "rod.stress", "rod_mid.deflection"]
    run = linkages.simulate(system, "compiled").within(0.08, 0.12)
    assert peaks["rod.stress"] == pytest.approx(run["rod.stress"].max(), rel=0.05)


@pytest.mark.slow
def test_a_turning_shaft_wears_the_exact_pocket(press):
    """100 N, 100 m, 5e-13 m2/N: the published row, 28.1219 um and 38.4630 deg, to 1e-3, by the whole machine."""
    turns = round(100.0 / (2.0 * math.pi * (RADIUS - CLEARANCE)))
    life = wear_life(press(), turns)
    assert life.status is linkages.Status.OK
    assert life.simulated < turns / 30
    profile = life.profiles("B")[-1, 0]
    assert profile.max() == pytest.approx(28.1219e-6, rel=1e-3)
    journal, phi = RADIUS - CLEARANCE, 2.0 * np.pi * np.arange(360) / 360 - 0.5 * np.pi
    e = CLEARANCE + 28.1219e-6
    crescent = e * np.cos(phi) + np.sqrt(journal**2 - (e * np.sin(phi)) ** 2) - RADIUS
    edge = math.acos((e * e + RADIUS**2 - journal**2) / (2.0 * e * RADIUS))
    assert math.degrees(edge) == pytest.approx(38.4630, rel=1e-5)
    exact = fitted_half_angle(np.maximum(crescent, 0.0), 0.5 * np.pi)
    assert fitted_half_angle(profile, 0.5 * np.pi) == pytest.approx(exact, rel=1e-3)


def test_a_driven_shaft_wears_its_own_bearing(tmp_path):
    """The loop of ideal joints closes in every block, whatever the turns before: the exact pocket of the volume."""
    system = linkages.load(write_press(tmp_path, driven=True), {"joints.O.wear.coefficient": 5e-11})
    life = wear_life(system, 16)
    assert life.status is linkages.Status.OK
    assert len(life.stages) > 2
    path = 2.0 * math.pi * (RADIUS - CLEARANCE) * 16
    area = 5e-11 * 100.0 * path / LENGTH
    assert life.depths("O")[-1] == pytest.approx(crescent(area)[0], rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "joints"),
    [("slider_crank_dry.toml", ("B",)), ("four_bar_dry.toml", None)],
    ids=["slider-crank", "four-bar"],
)
def test_worn_volume_is_the_coefficient_times_load_and_path(file, joints):
    """Archard's invariant to 1e-12, of both parts, with and without jumps."""
    plain = linkages.load(linkages.find_file(file))
    values = {}
    for name in joints or plain.tree.journals:
        table = f"joints.{name}.wear"
        values |= {f"{table}.coefficient": 2e-13, f"{table}.side": '"both"', f"{table}.hardness": [1e9, 3e9]}
        values |= {f"{table}.nodes": 120}
    system = linkages.load(linkages.find_file(file), values)
    for cycles, every in ((300, False), (2, True)):
        life = wear_life(system, cycles, scatter=0.2, every_cycle=every)
        assert life.status is linkages.Status.OK
        for one in life.joints:
            work = life.stages[-1].work[one.name]
            assert work > 0.0
            bearing, journal = life.volumes(one.name)[-1]
            assert bearing == pytest.approx(0.75 * 2e-13 * work, rel=1e-12)  # the softer part wears three times as much
            assert journal == pytest.approx(0.25 * 2e-13 * work, rel=1e-12)


def test_a_life_that_was_killed_goes_on_and_gives_the_same_bytes(press, tmp_path):
    system, folder = press(SPRING, **{"wear.coefficient": 3e-12, "wear.nodes": 120}), tmp_path / "blocks"
    whole = json.dumps(content(wear_life(system, 40, tolerance=5e-7)))
    assert json.dumps(content(wear_life(system, 40, tolerance=5e-7, folder=folder))) == whole
    files = sorted(folder.iterdir())
    assert len(files) > 2
    files[-1].unlink()
    files[-2].write_bytes(files[-2].read_bytes()[:1000])  # half a file, as none is written: it is made again
    assert json.dumps(content(wear_life(system, 40, tolerance=5e-7, folder=folder))) == whole
    assert sorted(folder.iterdir()) == files
    sound = files[0].read_bytes()
    for at in (10, 40, len(sound) // 2, sound.rindex(b"PK\x01\x02") + 8, len(sound) - 1):  # a bit, anywhere
        files[0].write_bytes(sound[:at] + bytes([sound[at] ^ 1]) + sound[at + 1 :])
        assert json.dumps(content(wear_life(system, 40, tolerance=5e-7, folder=folder))) == whole
        assert files[0].read_bytes() == sound
    other = wear_life(press(SPRING, **{"wear.coefficient": 2e-12, "wear.nodes": 120}), 20, folder=folder)
    assert other.volumes("B")[-1, 0] < 20 * 2e-12 * 7.0  # nothing of the other life


@pytest.mark.slow
@pytest.mark.processes
def test_a_command_that_was_killed_goes_on_whatever_the_number_of_threads(press, tmp_path):
    """SIGKILL as the third block is to be written, then another number of threads: the same bytes as in one go."""
    press(SPRING)
    settings = ["--set", "joints.B.wear.nodes=120", "--set", "joints.B.wear.coefficient=3e-12", "--tolerance", "2e-7"]
    words = ["wear", tmp_path / "press.toml", "--cycles", "60", *settings, "--no-plots", "--no-animation", "--out"]

    def ended(name, threads, at=0):
        environment = os.environ | {"NUMBA_NUM_THREADS": str(threads)}
        place = "linkages.explore.wear.block_store:keep"
        return finish(start(*words, tmp_path / name, env=environment, struck=(place, at, signal.SIGKILL)))

    assert ended("parts", 1, 3)[0] == 128 + signal.SIGKILL
    blocks = tmp_path / "parts" / "blocks"
    assert not (tmp_path / "parts" / "wear.json").exists()
    left = {path: path.stat().st_mtime_ns for path in blocks.glob("*.block")}
    assert ended("parts", 2) == ended("whole", 1) == (0, "")
    assert (tmp_path / "parts" / "wear.json").read_bytes() == (tmp_path / "whole" / "wear.json").read_bytes()
    assert len(left) == 2
    assert all(path.stat().st_mtime_ns == then for path, then in left.items())  # they were read, not made again


def test_the_life_until_a_limit(press):
    life = wear_life(press(SPRING, **{"wear.coefficient": 3e-12, "wear.nodes": 120}), 100, tolerance=2e-7)
    depths, cycles = life.depths("B"), life.cycles
    middle = 0.5 * (depths[1] + depths[2])
    until = life.cycles_until("B.depth", middle)
    assert cycles[1] < until < cycles[2]
    one, loads = life.stages[1].removed, life.stages[2].loads
    then = worn(life.joints, one, loads, until - cycles[1])  # within a jump: what its loads wear
    assert node_depths(depths_of(life.joints[0], then["B"])[0]).max() == pytest.approx(middle, rel=1e-4)
    assert life.cycles_until("B.depth", 1.0) == math.inf
    forces, at = life.peaks("B.force")
    assert list(at) == [stage.middle for stage in life.stages]
    assert (life.cycles_until("B.force", 0.5 * forces[0]), life.cycles_until("B.force", 2.0 * forces[0])) == (
        0,
        math.inf,
    )
    assert life.play("B")[-1] == pytest.approx(CLEARANCE + life.profiles("B")[-1, 0].mean())
    with pytest.raises(linkages.InputError, match=r"B.depth"):
        life.cycles_until("C.depth", 1.0)
    short = wear_life(life.system, 100, tolerance=2e-7, enough=lambda so_far: so_far.depths("B")[-1] > middle)
    assert short.cycles[-1] == cycles[2]


def test_a_jump_at_held_loads_is_its_parts_together(press):
    """The profile after m cycles of a block's loads is that after two times m/2 of them."""
    system = press(**{"wear.nodes": 120})
    life = wear_life(system, 1)
    joints, removed, loads = wearing(system), life.stages[0].removed, life.stages[0].loads
    once = worn(joints, removed, loads, 400.0)["B"][0]
    twice = worn(joints, worn(joints, removed, loads, 200.0), loads, 200.0)["B"][0]
    assert np.abs(once - twice).max() < 2e-3 * once.max()


RATE, SCALE = 1e-9, 1e-3


@pytest.fixture
def even_life(press, monkeypatch):
    """Lives in closed form: wear s even over the turn, by loads that fall with it, ds/dn = r/(1 + (s/S)^p)."""
    system = press(**{"wear.nodes": 120})

    def made(cycles, tolerance, power, scale=SCALE):
        def measure(self, removed, start, scatter, single=False):
            load = 1.0 / (1.0 + (removed["B"][0, 0] / scale) ** power)
            loads = {"B": np.array([[0.0, 0.0, 0.0, -CLEARANCE, 0.0, -1.0, load]])}
            nothing = BlockStart(np.zeros(0), np.zeros(0), 0.0)
            return CycleBlock(loads, {"B": np.array([load])}, {}, 1, nothing, linkages.Status.OK)

        def even(joints, removed, loads, cycles):
            return {"B": removed["B"] + cycles * RATE * loads["B"][:, -1].sum() * np.array([[1.0], [0.0]])}

        monkeypatch.setattr(BlockStore, "measure", measure)
        monkeypatch.setattr("linkages.explore.wear.life.worn", even)
        return wear_life(system, cycles, tolerance=tolerance)

    return made


def cycles_to(s, power):
    """Cycles in which so much is worn away: s + s^(p+1)/((p+1) S^p) = r n."""
    return (s + s ** (power + 1.0) / ((power + 1.0) * SCALE**power)) / RATE


@pytest.mark.parametrize(("power", "order"), [(1.0, 3.0), (2.0 / 3.0, 5.0 / 3.0)], ids=["worn", "round"])
def test_the_order_of_a_jump(even_life, power, order):
    """Local errors: of order 3, and 5/3 where the depth begins as V^(2/3), in a round joint."""
    errors = []
    for cycles in (25, 50, 100):
        life = even_life(cycles, 1.0, power)
        assert [stage.cycles for stage in life.stages] == [0, cycles]
        errors.append(abs(cycles_to(life.stages[-1].removed["B"][0, 0], power) - cycles))
    assert np.log2(np.array(errors[1:]) / errors[:-1]) == pytest.approx(order, abs=0.15)


def test_jumps_that_err_are_made_again_without_another_block_and_keep_the_second_order(even_life):
    """A quarter of the tolerance: half as long jumps, a quarter of the error at the end."""
    cycles, errors, counts = 1_500_000, [], []
    for tolerance in (2.4e-6, 6e-7, 1.5e-7):
        life = even_life(cycles, tolerance, 1.0)
        assert life.rejected > 0
        assert life.simulated == len(life.stages)  # a block for each jump, and the first
        assert max(stage.error for stage in life.stages) <= tolerance
        errors.append(abs(cycles_to(life.stages[-1].removed["B"][0, 0], 1.0) / cycles - 1.0))
        counts.append(len(life.stages))
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.4)
    assert np.array(counts[1:]) / counts[:-1] == pytest.approx(2.0, abs=0.3)


def test_a_life_ends_where_the_profiles_are_too_deep_and_not_a_jump_before(even_life):
    """Jumps grow by factors of five while loads stay: the last ones are shortened to end at a fifth of the radius."""
    life = even_life(10**9, 1e-5, 1.0, scale=1e9)
    assert life.status is linkages.Status.WORN_OUT
    assert DEEPEST * RADIUS - 2e-5 < life.depths("B")[-1] <= DEEPEST * RADIUS


def test_a_block_ends_when_its_last_cycles_are_known_well_enough():
    """The kept cycles' mean is close to the mean of all, for periodic, alternating, transient and chaotic motions."""

    def kept(works):
        for count in range(1, len(works) + 1):
            last = _settled(works[:count, None], 0.01)
            if last:
                return works[count - last : count]
        return works[4:]

    assert len(kept(np.ones(16))) == 2
    assert np.mean(kept(1.0 + 0.004 * (-1.0) ** np.arange(16))) == pytest.approx(1.0, abs=0.002)
    assert np.mean(kept(1.0 + 0.5 * 0.3 ** np.arange(16))) == pytest.approx(1.0, abs=0.01)
    chaotic = 1.0 + 0.03 * np.random.default_rng(1).standard_normal((400, 16))
    assert np.std([np.mean(kept(works)) for works in chaotic]) < 0.02  # more than required: few cycles can look alike
    both = np.column_stack([np.ones(4), [1.0, 2.0, 1.0, 2.0]])
    assert _settled(both, 0.01) == 0  # every joint must be known


def test_the_command_writes_the_contract(press, tmp_path, capsys):
    press(SPRING)
    out = tmp_path / "out"
    status = main(
        ["wear", str(tmp_path / "press.toml"), "--cycles", "20", "--out", str(out), "--set", "joints.B.wear.nodes=120"]
    )
    assert status == 0
    assert {path.name for path in out.iterdir()} == {
        "record.json",
        "wear.json",
        "wear_B.png",
        "wear_history.png",
        "wear.html",
        "blocks",
    }
    found = json.loads((out / "wear.json").read_text())
    joint = found["joints"]["B"]
    assert (found["cycles"], found["status"]) == (20, "ok")
    profile = np.array(joint["profile"])
    assert profile.shape == (120, 2)
    assert joint["depth"] == profile[:, 1].max()
    assert joint["volume"] == pytest.approx(5e-13 * joint["load_distance"], rel=1e-12)
    assert found["blocks"][-1]["cycles"] == 20
    assert "20 cycles" in capsys.readouterr().out
    assert main(["report", str(out)]) == 0
    page = (out / "report.html").read_text(encoding="utf-8")
    assert number(1e9 * joint["volume"]) in page
    assert page.count("data:image/png;base64,") == 2
    assert '<iframe title="Growing pockets"' in page
    (out / "wear.json").write_text('{"cycles": 20}')
    assert main(["report", str(out)]) == 2
    error = capsys.readouterr().err
    assert error == "error: wear.json: status: is missing\n"
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--cycles", "0"], "--cycles: 0: must be a whole number above zero"),
        (["--cycles", "1.5"], "--cycles: 1.5: must be a whole number above zero"),
        (["--cycles", "5", "--tolerance", "-1"], "--tolerance: is -1; it must be above zero"),
        (["--cycles", "5", "--drive", "B"], '--drive: "B" has no prescribed motion; known are: O'),
        (["--cycles", "5", "--set", "joints.B.wear.coefficient=0"], "joints.B.wear.coefficient"),
        (["--cycles", "5", "--set", 'joints.B.wear.side="both"'], 'side "both" needs share or hardness'),
        (["--cycles", "5", "--set", "joints.B.wear.share=0.5"], 'share belongs to side "both"; remove it'),
        (["--cycles", "5", "--set", "joints.B.wear.bearing_depth=[1e-6]"], "bearing_depth has 1 depths for 360 nodes"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(press, tmp_path, capsys, words, message):
    press()
    assert main(["wear", str(tmp_path / "press.toml"), "--out", str(tmp_path / "out"), *words]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_gear_after_whose_cycle_the_wheels_have_turned_by_a_fraction_is_refused(tmp_path):
    path = write_press(tmp_path)
    wheel = solid("wheel", 1.0, 1e-3) + joint("W", "world", "wheel")
    (tmp_path / "press.sdf").write_text(SDF.replace("</model>", wheel + "</model>"))
    path.write_text(path.read_text() + "[gears.pair]\njoints = ['O', 'W']\nratio = -0.5\n")
    with pytest.raises(linkages.InputError, match=r"press.toml: gears\.pair\.ratio: is no whole number"):
        wear_life(linkages.load(path), 10)
    whole = linkages.load(path, {"gears.pair.ratio": -2.0})
    assert wear_life(whole, 10).status is linkages.Status.OK


def test_a_machine_without_wear_is_refused(tmp_path, capsys):
    assert main(["wear", "slider_crank_dry.toml", "--cycles", "5", "--out", str(tmp_path / "out")]) == 2
    assert "no joint wears; give one a table [joints.NAME.wear]" in capsys.readouterr().err


@pytest.mark.slow
def test_the_slider_crank_of_the_literature_wears_in_two_zones_along_the_sliders_way():
    """Where the rod pulls and where it pushes, as the published profiles of worn slider-cranks have it."""
    life = wear_life(linkages.load(linkages.find_file("slider_crank_wear.toml")), 100_000)
    profile = life.profiles("B")[-1, 0]
    deep = profile > 0.2 * profile.max()
    assert np.sum(deep & ~np.roll(deep, 1)) == 2
    along = np.cos(2.0 * np.pi * np.arange(len(profile)) / len(profile))
    for side in (along, -along):
        pocket = np.where(side > 0.0, profile, 0.0)
        assert pocket.max() > 0.5 * profile.max()
        assert side[np.argmax(pocket)] > math.cos(math.radians(30.0))
