"""Wear over the service life: blocks of simulated cycles, and jumps between them.

| module      | responsibility                                                           |
|-------------|--------------------------------------------------------------------------|
| measure     | a block of cycles with constant profiles: loads, peaks, scatter          |
| stages      | jumps, stages, the time to reach a limit; content of ``wear.json``       |
| life        | jumps of second order from block to block, step control                  |
| block_store | store of blocks on disk, from which an interrupted calculation continues |

A *cycle* is a revolution of the drive, or a period of an oscillating drive. A block with given profiles gives samples
of the loads (`linkages.laws.wear.archard.SAMPLE`) in a mean cycle; a jump of many cycles wears the profiles by these
samples at constant loads. The step control of the jumps follows the change of loads and motion with the profiles.
"""
