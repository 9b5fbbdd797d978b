"""Figures: the public path of `linkages.show.plots`."""

import sys

from linkages.show import plots

sys.modules[__name__] = plots
