"""The patent's claims beside our numbers: CN106055749A (Bai, Zhao and Sun, 2016). See `replication.patent_designs`."""

from __future__ import annotations

from replication import dry, patent_background, patent_method
from replication import patent_designs as designs
from replication.claims import change
from replication.computed import read
from replication.recorded import load_record
from replication.verdicts import Change, Claim, Interval, parts

PRINTED = -77.5  # %, [0087]: largest departure of the acceleration
SIZE = "follower_B.acceleration"
#: Commands that compute the numbers which are kept.
SEARCH = "python benchmarks/fourbar_landscape.py nearby"
DRAKE = "python docs/make_designs.py --drake fourbar_jitter"


def gain() -> list[Claim]:
    """[0087], as we read it, and as it could be read."""
    pair, record = designs.pair("fourbar_jitter"), load_record("fourbar_jitter")
    departure, size = (dry.stored(pair.name, output) for output in (None, SIZE))
    engine = 100.0 * (record.drake["jitter"] - 1.0)
    again = [-100.0 * part for part in read("fourbar_landscape")["nearby"]]
    starts = f"{dry.STARTS} start angles"
    least, most = (100.0 * (value - 1.0) for value in sorted(record.spread or [], reverse=True))
    digits = f"{least:+.2f} to {most:+.2f} % at four tolerances with forty roundings"
    return [
        Claim(
            "largest departure of the acceleration, [0087]", f"{PRINTED} %",
            f"{departure.start} in the first two revolutions, over {starts}",
            [departure.start.judged(PRINTED)],
            f"{pair.gain:+.1f} % from the drawn start ({digits}). Bounds of a third to thrice the nominal lengths: [narrower ones](#landscape) give smaller reductions", stored=f"{dry.COMMAND} {pair.name}", chosen=True,
        ),
        Claim(
            "the same, searched for again", f"{PRINTED} %",
            f"{max(again):+.1f} to {min(again):+.1f} % in {len(again)} searches whose first designs differ by a ten-millionth",
            [Interval(PRINTED, min(again), max(again), "%")],
            "a step that just meets or just misses a jump of the objective decides the valley, also on another processor", stored=SEARCH,
            trial=True,
        ),
        Claim(
            "the same on Drake, drawn start", f"{PRINTED} %", f"{engine:+.1f} %, compiled {pair.gain:+.1f} %", [Change(PRINTED, engine, "%")],
            "another engine with the same laws, minutes; two revolutions from the one start of the recorded design are reproducible", stored=DRAKE,
            trial=True,
        ),
        Claim(
            "the same of the running machine", f"{PRINTED} %", f"{departure.running}, medians over {starts} and ten revolutions",
            [departure.running.judged(PRINTED)], "robust objective: rounding, start and tolerance have little influence",
            stored=f"{dry.COMMAND} {pair.name}", trial=True,
        ),
        Claim(
            "the same design, if eq. (8) means the size of a_c itself, of B on the follower", f"{PRINTED} %",
            f"{size.start} at the start, {size.running} running", [size.start.judged(PRINTED)],
            f"the follower is three times as long: its angular acceleration decreases more than the acceleration of its end. If eq. (8) is read in this way, the objective is the output `{SIZE}`", stored=f"{dry.COMMAND} {pair.name}", trial=True,
        ),
    ]  # fmt: skip


def kept() -> list[Claim]:
    """Give the same gain for a linkage that does the same work."""
    pair = designs.pair("fourbar_kept")
    (_, slow), (_, fast) = (designs.spans(pair, "follower.omega")[k] for k in (0, 1))
    departure, size, force = (dry.stored(pair.name, output) for output in (None, SIZE, "B.force"))
    return [
        Claim(
            "largest departure of the acceleration where the machine still does its work", f"{PRINTED} %",
            f"{departure.start} at the start, {departure.running} running (size of a_c {size.running}, F_B {force.running})",
            [departure.start.judged(PRINTED)],
            "study `fourbar_kept`: Freudenstein's ratios of the lengths within 5 %, the joint's largest force from the recorded start not larger"
            f" (fastest follower {slow:.1f} -> {fast:.1f} rad/s); lengths {pair.lengths} mm",
            because=[], stored=f"{dry.COMMAND} {pair.name}", trial=True,
        )
    ]  # fmt: skip


def price() -> list[Claim]:
    """State the cost of the design of the first row; the patent does not."""
    pair = designs.pair("fourbar_jitter")
    before, after = (f"{low:.0f} to {high:.0f}" for low, high in designs.spans(pair, "follower.omega"))
    played, forces = dry.stored(pair.name, "B.force"), pair.peaks("B.force", perfect=True)

    return [
        Claim(
            "largest force in the clearance joint", "not given", f"{played.start} at the start, {played.running} running", [],
            "the impacts at the start are stronger: they turn a longer, heavier follower less. In the steady state the joint separates rarely",
            stored=f"{dry.COMMAND} {pair.name}",
        ),
        Claim(
            "largest force in the same joint without clearance", "not given",
            f"{1e-3 * forces[0]:.2f} -> {1e-3 * forces[1]:.2f} kN ({change(*forces):+.0f} %)", [], "longer and heavier bars",
        ),
        Claim(
            "speed of the ideal follower over a turn", "not given", f"{before} -> {after} rad/s", [],
            "the machine has another function: the ground is so short that the follower turns almost with the crank",
        ),
    ]  # fmt: skip


def peaks() -> list[Claim]:
    """Fig. 4, [0087]: countable statements."""
    pair = designs.pair("fourbar_jitter")
    departure, found = dry.stored(pair.name), dry.counted(pair.name)
    told = {
        key: " -> ".join(f"{middle:g} ({low:.0f} to {high:.0f})" for middle, low, high in both)
        for key, both in found.items()
    }
    return [
        Claim(
            "peaks of the acceleration lower and fewer, fig. 4, [0087]", "clearly both",
            f"largest departure {departure.start}; contacts in two revolutions {told['contacts']}; above half of the"
            f" nominal largest departure {told['above']} times",
            [parts([departure.start.high < 0.0, *(after[2] < before[1] for before, after in found.values())])],
            f"medians and 5 to 95 % over {dry.COUNTED} start angles; a part holds if the intervals do not overlap",
            stored=f"{dry.COMMAND} {pair.name}",
        ),
        Claim(
            "optimised lengths, table 2", "lost", f"{pair.lengths} mm (ground, crank, coupler, follower)", [],
            "the table is not in the text",
        ),
        Claim(
            "formulas (1)-(9), [0015]-[0026], [0036]-[0080]", "lost; names of symbols remain",
            "contact of Lankarani and Nikravesh, stiffness of Hertz, friction in cubic steps", [],
            "the laws named by the remaining words, from the literature; this applies wherever these paragraphs are cited",
        ),
    ]  # fmt: skip


def others() -> list[Claim]:
    """[0082]: linkages with more bars."""
    listed = {
        "five-bar, two driven cranks": "fivebar_jitter",
        "six-bar, Watt's": "sixbar_jitter",
        "seven-bar, two dry joints": "sevenbar_jitter",
    }
    found = []
    for what, name in listed.items():
        record, departure = load_record(name), dry.stored(name)
        forces = {output: dry.stored(name, output).running for output in dry.CASES[name].outputs[1:]}
        told = ", ".join(f"F_{output.partition('.')[0]} {value}" for output, value in forces.items())
        found.append(
            Claim(
                f"for other linkages as well, [0082]: {what}", "none",
                f"departure {departure.start} at the start, {departure.running} running; {told}",
                [parts([departure.start.high < 0.0, departure.running.high < 0.0])],
                f"it holds if the whole interval decreases, at the start and in the steady state. Study `{name}`, lengths within assumed bounds;"
                f" {record.evaluations} designs, seed {record.seed}", stored=f"{dry.COMMAND} {name}",
            )
        )  # fmt: skip
    return found


SECTIONS = {
    "gain": gain, "kept": kept, "price": price, "peaks": peaks, "others": others, "method": patent_method.method,
    "background": patent_background.background,
}  # fmt: skip
