"""What comes of a run: trajectories, and numbers over continuous time. It knows no engine.

| module        | responsibility                                                           |
|---------------|--------------------------------------------------------------------------|
| trajectory    | outputs over time, a status, where they come from; save and load         |
| loops         | how far the loops of a run are open, and up to where they hold           |
| extremes      | smallest and largest values over continuous time, integrals              |
| characteristics | extremes, forces, torques, work and contacts of a run or a part of it     |
| configuration | where journals and free coordinates are, as numbers to compare            |
| steady_state  | what kind of motion a run ends in, and its steady cycle                   |
| akima         | values between samples                                                   |
| impacts       | contacts one by one; flight, impact and sustained contact                |
| startup       | how long joints that can touch start up                                  |
| singular      | singular positions that a motion passes or comes near                    |
| divergence    | how long two runs of one system stay together                            |
| noise         | rounding as a magnitude: below it an output is zero                      |
| peak_errors   | errors of peaks, from a run at a tighter tolerance                       |
| joint_validity | where a run leaves the range that a law holds for                        |
| film_error    | error of a closed-form film in a run, beside a film of finite length     |
| flexible_validity | where it leaves the range of the model of links that bend                |
| validity      | what says so, and its warnings                                           |
| indeterminate | forces and torques that the motion does not determine                   |
| warnings      | what must be known before the numbers of a summary are trusted           |
| summary       | a run with what is needed to judge it, and the contents of summary.json  |
| shape         | the keys of summary.json and wear.json, to check a file that is read     |
"""
