"""How functions are compiled: `kernel` and its relatives, named tuples by reference, calls by address, lanes.

| module       | responsibility                                                      |
|--------------|---------------------------------------------------------------------|
| compile      | `kernel`, `inlined_kernel`: the compiler of all numerical kernels   |
| lazy         | `lazy_kernel`: compiled at the first call                           |
| by_address   | functions called by address: force laws                             |
| by_reference | named tuples passed by reference                                    |
| block        | a named tuple and its arrays in one block of memory                 |
| simd         | SIMD lanes: one operation for several numbers                       |
| clear        | arrays filled with zeros                                            |
| ownership    | reference counts only in functions that make arrays                 |
| units        | external functions, compiled once, linked by symbol                 |
| fingerprint  | the fingerprint of a function: code, constants, functions it calls  |
| folder       | the folder of compiled code                                         |
| cache        | compiled code on disk, by fingerprint                               |
| locks        | which process compiles which kernel                                 |
| precompiled  | kernels compiled in advance by parallel processes                   |
"""

from linkages.arrays import Array, Indices, Records, record_type
from linkages.kernel.by_address import address, caller
from linkages.kernel.clear import clear
from linkages.kernel.compile import inlined_kernel, kernel
from linkages.kernel.lazy import lazy_kernel

__all__ = [
    "Array",
    "Indices",
    "Records",
    "address",
    "caller",
    "clear",
    "inlined_kernel",
    "kernel",
    "lazy_kernel",
    "record_type",
]
