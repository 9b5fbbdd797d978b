"""How functions are compiled: `kernel` and its relatives, references to named tuples, calls by address."""

from linkages.kernel.compile import address, inlined_kernel, kernel, template

__all__ = ["address", "inlined_kernel", "kernel", "template"]
