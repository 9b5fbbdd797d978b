"""How functions are compiled: `kernel` and its relatives, references to named tuples, calls by address."""

from linkages.kernel.by_address import address, caller
from linkages.kernel.compile import inlined_kernel, kernel, template

__all__ = ["address", "caller", "inlined_kernel", "kernel", "template"]
