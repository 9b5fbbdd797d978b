"""What comes of a run: trajectories, and numbers over continuous time. It knows no engine.

| module        | responsibility                                                           |
|---------------|--------------------------------------------------------------------------|
| trajectory    | outputs over time, a status, where they come from; save and load         |
| loops         | how far the loops of a run are open, and up to where they hold           |
| extremes      | smallest and largest values over continuous time, integrals              |
| numbers       | extremes, forces, torques, work and contacts of a run or a part of it     |
| configuration | where journals and free coordinates are, as numbers to compare            |
| settling      | what kind of motion a run ends in, and its steady cycle                   |
| akima         | values between samples                                                   |
| impacts       | contacts one by one; flight, impact and sustained contact                |
| startup       | how long joints that can touch start up                                  |
| singular      | singular positions that a motion passes or comes near                    |
| parting       | how long two runs of one system stay together                            |
| noise         | rounding as a magnitude: below it an output is zero                      |
| errors        | errors of peaks, from a run at a tighter tolerance                       |
| ranges        | where a run leaves the range that a law holds for                        |
| bent_ranges   | where it leaves the range of the model of links that bend                |
| rules         | what says so, and its warnings                                           |
| indeterminate | forces and torques that the motion does not determine                   |
| warnings      | what must be known before the numbers of a summary are trusted           |
| summary       | a run with what is needed to judge it, and the contents of summary.json  |
| shape         | the keys of summary.json and wear.json, to check a file that is read     |
"""
