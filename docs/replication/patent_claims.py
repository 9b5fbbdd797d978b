"""The patent's claims beside our numbers: CN106055749A (Bai, Zhao and Sun, 2016). See `replication.patent_designs`."""

from __future__ import annotations

from replication import patent_designs as designs
from replication.claims import change
from replication.patent_designs import SETTLED
from replication.recorded import load_record
from replication.verdicts import Claim, Number, parts

PRINTED = -77.5  # %, [0087]: largest departure of the acceleration
SIZE = "follower_B.acceleration"
LOST = "tables 1 and 2 and formula (8), which are lost in the text"


def _number(found: float) -> list[Number]:
    return [Number(PRINTED, found, "%")]


def gain() -> list[Claim]:
    """[0087], as we read it, and as it could be read."""
    pair, record = designs.pair("fourbar_jitter"), load_record("fourbar_jitter")
    linear, drake = pair.peaks(SIZE), 100.0 * (record.drake["jitter"] - 1.0)
    mean, later = designs.change_of_the_mean(pair.name), designs.change_after_the_start(pair.name)
    return [
        Claim(
            "largest departure of the acceleration, [0087]", f"{PRINTED} %",
            f"{pair.gain:+.1f} % within bounds of a third to thrice the nominal lengths", _number(pair.gain),
            "the bounds are ours, chosen so wide that the printed gain is within reach: no evidence for the printed"
            " number, [narrower ones](fourbar_landscape.md#what-the-lost-bounds-decide) give less. What eq. (8) takes of"
            " the acceleration is lost; here the follower's angular one less the ideal linkage's", LOST,
        ),
        Claim(
            "the same on Drake", f"{PRINTED} %", f"{drake:+.1f} %, as recorded", _number(drake),
            "another engine with the same laws; minutes, `python docs/make_designs.py --drake fourbar_jitter`", LOST,
        ),
        Claim(
            "the same design, if eq. (8) means the size of a_c itself, of B on the follower", f"{PRINTED} %",
            f"{change(*linear):+.1f} % ({linear[0]:.0f} -> {linear[1]:.0f} m/s²)", _number(change(*linear)),
            "the follower is three times as long: its angular acceleration falls more than that of its end. Who reads (8) so"
            f" minimises the output `{SIZE}`", LOST,
        ),
        Claim(
            "the same from ten other start angles", "not asked", f"{mean:+.1f} %", [],
            "our question: the objective sees two revolutions from one start",
        ),
        Claim(
            f"the same after the start, from {SETTLED:g} s", "not asked", f"{later:+.1f} %", [],
            "our question: the largest departures are in the first half revolution, after flights across the clearance",
        ),
    ]  # fmt: skip


def kept() -> list[Claim]:
    """Give the same gain for a linkage that does the same work."""
    pair = designs.pair("fourbar_kept")
    (_, slow), (_, fast) = (designs.spans(pair, "follower.omega")[k] for k in (0, 1))
    return [
        Claim(
            "largest departure of the acceleration where the machine still does its work", f"{PRINTED} %",
            f"{pair.gain:+.1f} % (size of a_c {pair.change(SIZE):+.1f} %)", _number(pair.gain),
            "study `fourbar_kept`: Freudenstein's ratios of the lengths within 5 %, the joint's largest force no larger"
            f" ({pair.change('B.force'):+.1f} %; fastest follower {slow:.1f} -> {fast:.1f} rad/s); lengths {pair.lengths} mm", LOST,
        )
    ]  # fmt: skip


def price() -> list[Claim]:
    """Say what the design of the first row costs; the patent says nothing of it."""
    pair = designs.pair("fourbar_jitter")
    before, after = (f"{low:.0f} to {high:.0f}" for low, high in designs.spans(pair, "follower.omega"))

    def newtons(perfect: bool) -> str:
        forces = pair.peaks("B.force", perfect)
        return f"{1e-3 * forces[0]:.2f} -> {1e-3 * forces[1]:.2f} kN ({change(*forces):+.0f} %)"

    return [
        Claim(
            "largest force in the joint with play", "not said", newtons(perfect=False), [],
            "the blows are harder: a longer, heavier follower turns less under them",
        ),
        Claim("largest force in the same joint without play", "not said", newtons(perfect=True), [], "longer and heavier bars"),
        Claim(
            "speed of the ideal follower over a turn", "not said", f"{before} -> {after} rad/s", [],
            "the machine does another job: the ground is so short that the follower nearly turns with the crank",
        ),
    ]  # fmt: skip


def peaks() -> list[Claim]:
    """Fig. 4, [0087]: what can be counted."""
    pair = designs.pair("fourbar_jitter")
    many, few = map(len, pair.impacts)
    first, last = pair.times_above_half("follower.alpha")
    return [
        Claim(
            "peaks of the acceleration lower and fewer, fig. 4, [0087]", "clearly both",
            f"largest departure {pair.gain:+.1f} %; contacts in two revolutions {many} -> {few}; above half of the"
            f" nominal largest departure {first} -> {last} times",
            [parts([pair.gain < 0.0, few < many, last < first])], "counted, each by itself",
            "the figure, which is not in the text",
        ),
        Claim(
            "optimised lengths, table 2", "lost", f"{pair.lengths} mm (ground, crank, coupler, follower)", [],
            "the table is not in the text",
        ),
        Claim(
            "formulas (1)-(9), [0015]-[0026], [0036]-[0080]", "lost; names of symbols are left",
            "contact of Lankarani and Nikravesh, stiffness of Hertz, friction in cubic steps", [],
            "what the words name, as the literature has it; so wherever these paragraphs are cited",
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
        record = load_record(name)
        found.append(
            Claim(
                f"for other linkages as well, [0082]: {what}", "no numbers", _gained(name, record.spread), [],
                f"study `{name}`, lengths within bounds of ours; {record.evaluations} designs, seed {record.seed}"
                + ("; the nominal run has no digits, its blows hang on all before them" if record.spread else ""),
            )
        )  # fmt: skip
    return found


def _gained(name: str, spread: list[float] | None) -> str:
    """Say what a recorded design gains: where a run has no digits, over which range."""
    if spread is not None:
        least, most = (100.0 * (value - 1.0) for value in sorted(spread, reverse=True))
        return f"largest departure {least:+.1f} to {most:+.1f} %, as recorded at four tolerances and with rounding"
    pair = designs.pair(name)
    forces = ", ".join(f"F_{joint} {pair.change(f'{joint}.force'):+.0f} %" for joint in pair.joints)
    return f"largest departure {pair.gain:+.1f} %; {forces}"


SECTIONS = {"gain": gain, "kept": kept, "price": price, "peaks": peaks, "others": others}
