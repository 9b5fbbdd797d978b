"""A machine as a labelled picture: what is to be drawn is data, which each renderer puts on its own paper.

| module  | responsibility                                                                                     |
|---------|----------------------------------------------------------------------------------------------------|
| shapes  | `Shape`: points fixed to bodies and how they look; the table of styles                             |
| room    | where there is still room for a name                                                               |
| parts   | the shapes of links, joints, ground, points                                                        |
| directions | which way drives go and loads act                                                                  |
| actions | the shapes of what is done with the machine: drives, loads, gears, stops                           |
| drawing | `Drawing`: all shapes of a machine, and its poses over the way of each drive                       |
| facts   | what is to be known of the machine, in sentences                                                   |
| svg     | a drawing -> SVG                                                                                   |
| raster  | a drawing -> a matplotlib figure: PNG, moving GIF                                                  |
| slider_page | a drawing -> an HTML page with a slider for each drive                                             |
"""

from linkages.plots.drawing.drawing import Drawing, draw
from linkages.plots.drawing.slider_page import page
from linkages.plots.drawing.svg import svg

__all__ = ["Drawing", "draw", "page", "svg"]
