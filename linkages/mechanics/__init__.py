"""Mechanics on plain arrays: integrators, elastic bodies (`flexible`), planar multibody kernels (`planar`)."""
