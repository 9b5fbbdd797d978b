"""Property tests call compiled functions: the first call compiles, so no deadline per example."""

from hypothesis import settings

settings.register_profile("laws", deadline=None)
settings.load_profile("laws")
