"""How functions are compiled: `kernel` and its relatives, named tuples by reference, calls by address, SIMD lanes.

| module       | responsibility                                                                 |
|--------------|--------------------------------------------------------------------------------|
| compile      | `kernel`, `inlined_kernel`, `lazy_kernel`: the compiler of all numerical kernels |
| stored       | code of functions: loaded from disk, or compiled and kept there                |
| external     | external functions: compiled or loaded once, called at their address           |
| passing      | how external functions take and return vectors                                 |
| lazy_calls   | calls of lazy kernels, which the first call compiles or loads                  |
| law_calls    | calls of force laws at an address                                              |
| by_reference | named tuples passed by reference                                               |
| block        | a named tuple and its arrays in one piece of memory                            |
| dual         | dual numbers: a number and its derivatives, as a type of numba                 |
| dual_copy    | a named tuple whose numbers are duals                                          |
| dual_lanes   | duals side by side                                                             |
| simd         | SIMD lanes: one operation for several numbers                                  |
| fingerprint  | the fingerprint of a function: code, constants, functions it calls             |
| folder       | the folder of compiled code                                                    |
| cache        | compiled code on disk, by fingerprint                                          |
| shipped      | compiled code in a wheel                                                       |
| locks        | which process compiles which kernel                                            |
| precompiled  | kernels compiled in advance by parallel processes                              |
| private      | numba's private names, with their reasons; its layout of arrays                |
"""

from linkages.base.arrays import Array, Indices, Records, record_type
from linkages.base.kernel import dual_lanes as _dual_lanes  # noqa: F401 - teaches simd
from linkages.base.kernel.compile import bound, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.law_calls import address, caller

__all__ = [
    "Array",
    "Indices",
    "Records",
    "address",
    "bound",
    "caller",
    "inlined_kernel",
    "kernel",
    "lazy_kernel",
    "record_type",
]
