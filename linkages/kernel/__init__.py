"""How functions are compiled: `kernel` and its relatives, named tuples by reference, calls by address, lanes."""

from linkages.kernel.by_address import address, caller
from linkages.kernel.clear import clear
from linkages.kernel.compile import inlined_kernel, kernel
from linkages.kernel.late import late_kernel
from linkages.kernel.types import Array, Indices, Records, record_type

__all__ = [
    "Array",
    "Indices",
    "Records",
    "address",
    "caller",
    "clear",
    "inlined_kernel",
    "kernel",
    "late_kernel",
    "record_type",
]
