"""How functions are compiled: `kernel` and its relatives, references to named tuples, calls by address."""

from linkages.kernel.compile import inlined_kernel, kernel, template
from linkages.kernel.pointer import address, caller

__all__ = ["address", "caller", "inlined_kernel", "kernel", "template"]
