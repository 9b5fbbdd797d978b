"""A mechanism as a labelled picture: shapes as data, and renderers for several formats.

| module      | responsibility                                                                        |
|-------------|---------------------------------------------------------------------------------------|
| shapes      | `Shape`: points fixed to bodies; the table of styles                                  |
| parts       | shapes of links, joints, ground, points; free space for names                         |
| actions     | shapes and directions of drives, loads, gears, stops                                  |
| drawing     | `Drawing`: all shapes of a mechanism, and its poses over each drive's range of motion |
| facts       | properties of the mechanism in sentences and tables                                   |
| svg         | a drawing -> SVG, HTML page with a slider for each drive                              |
| poses       | poses of a drawing's bodies over a run                                                |
| moving      | a drawing and a run -> GIF, MP4                                                       |
| replay      | a drawing and a run -> HTML page with a slider of time                                |
| raster      | a drawing -> a matplotlib figure                                                      |
"""

from linkages.show.plots.drawing.drawing import Drawing, draw
from linkages.show.plots.drawing.svg import page, svg

__all__ = ["Drawing", "draw", "page", "svg"]
