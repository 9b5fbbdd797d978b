"""Jumps against every cycle simulated, for the dry slider-crank; the literature's life: ``python benchmarks/wear.py``.

Worn volume, profile and processor time of a life of 1,000 cycles, by jumps at several tolerances and cycle by cycle
(some six minutes); then 10^6 revolutions of ``slider_crank_wear.toml``. The figures are in docs/wear_model.md.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import linkages
from linkages.explore.wear.measure import measure

#: k [m2/N] at which 1,000 cycles wear a third of the clearance away, and the loads grow by a tenth.
COEFFICIENT = 2e-12
TOLERANCES = (0.01, 0.02)  # of the clearance
BLOCK = 50  # cycles of a mean


def timed(system, cycles, **options):
    """Return a life, and the time that the processor took [s]."""
    start = time.process_time()
    life = linkages.wear_life(system, cycles, **options)
    return life, time.process_time() - start


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cycles", type=int, default=1000)
    cycles = parser.parse_args().cycles
    plain = linkages.load(linkages.find_file("slider_crank_wear.toml"))
    system = plain.replaced({"joints.B.wear.coefficient": COEFFICIENT})
    clearance = linkages.wear_life(system, 1).joints[0].clearance  # compiles, too

    every, cost = timed(system, cycles, every_cycle=True)
    reference, volume = every.profiles("B")[-1, 0], every.volumes("B")[-1, 0]
    work = np.array([stage.block.work["B"].mean() for stage in every.stages[1:]])
    blocks = work[: len(work) // BLOCK * BLOCK].reshape(-1, BLOCK)
    print(f"every cycle: {1e9 * volume:.5g} mm3, depth {1e6 * reference.max():.4g} um, {cost:.4g} s")
    print(f"work of a cycle [N m], means of {BLOCK}:", blocks.mean(axis=1).round(2))
    print("their standard deviations:", blocks.std(axis=1).round(2))
    print("tolerance/c  simulated  rejected  volume  profile (L2)  profile (largest)  cost")
    for part in TOLERANCES:
        life, spent = timed(system, cycles, tolerance=part * clearance)
        difference = life.profiles("B")[-1, 0] - reference
        size = np.linalg.norm(difference) / np.linalg.norm(reference)
        largest = np.abs(difference).max() / reference.max()
        print(
            f"{part:11.2f}{life.simulated:11d}{life.rejected:10d}{life.volumes('B')[-1, 0] / volume - 1.0:+8.2%}"
            f"{size:14.2%}{largest:19.2%}{cost / spent:5.0f} x"
        )

    last = every.stages[-1]
    for name, removed in (("round", every.stages[0].removed), ("worn", last.removed)):
        measure(system, removed, last.block.end, 0.0)
        start = time.process_time()
        block = measure(system, removed, last.block.end, 0.0)
        print(f"a cycle of the {name} joint: {1e3 * (time.process_time() - start) / block.cycles:.0f} ms")

    life, spent = timed(plain, 1_000_000)
    print(f"10^6 revolutions: {life.status.value}, {life.simulated} simulated, {spent:.3g} s;", end=" ")
    print(f"depth {1e6 * life.depths('B')[-1]:.4g} um, play {1e6 * life.play('B')[-1]:.4g} um")


if __name__ == "__main__":
    main()
