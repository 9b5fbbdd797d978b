"""Wear over a machine's life: blocks of simulated cycles, and jumps between them.

| module  | responsibility                                                                     |
|---------|------------------------------------------------------------------------------------|
| measure | a block of cycles with the profiles as they are: what wears where, peaks, spread   |
| jump    | profiles worn by a block's loads                                                   |
| stages  | what a life looks like, and when a limit is reached                                |
| life    | jumps of second order from block to block, step control                            |
| content | a life as the content of ``wear.json``                                             |
| block_store | blocks kept on disk by what they were made of: a life that was killed goes on      |

A *cycle* is a revolution of the drive, or a period of a drive that oscillates. A block with given profiles gives
samples of the loads (`linkages.laws.wear.archard.SAMPLE`) in a mean cycle; a jump wears the profiles by them, at held
loads, as many times as it has cycles. How loads and motion change with the profiles is what the steps of the jumps have
to follow.
"""
