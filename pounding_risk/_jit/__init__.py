"""Every decision about numba and LLVM: compile flags, the cache of compiled kernels, calls by address. Private."""
