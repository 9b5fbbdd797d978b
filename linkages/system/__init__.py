"""The numeric model, built once from a mechanism and an experiment; everything after it takes a `System`.

| module       | responsibility                                                       |
|--------------|----------------------------------------------------------------------|
| system       | `System`: the assembled start, all arrays; `load`                    |
| unassembled  | `Unassembled`: tree, motions, loads, contacts and their records      |
| tree         | spanning tree: what carries the bodies, what is cut, the coordinates |
| spanning     | how that tree grows                                                  |
| flexible_link | a link that bends: its frame, modes and sections                     |
| deflection   | the shape of links that bend at t = 0                                |
| static_system | a system that stands still in a pose, its prescribed joints held     |
| rigid_segments | the same linkage with rigid pieces in place of links that bend       |
| law_records  | joint models -> the records that the force laws read                 |
| load_records | applied loads -> the records that the kernels read                   |
| unilateral_contacts | limit stops, points at straight lines -> records of contacts         |
| assembly     | loop closure on the drawn branch, the consistent state at t = 0      |
| rate         | how fast a linkage without prescribed motions moves                   |
| equilibrium  | where journals lie at rest under their loads: another start          |
| ideal_motion | the ideal linkage's motion over time                                 |
| reference_configuration | a machine drawn anew: closed, every joint within its limits          |
"""

from linkages.system.system import System, load

__all__ = ["System", "load"]
