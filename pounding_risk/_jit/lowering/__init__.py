"""Settings of numba and LLVM for kernels."""
