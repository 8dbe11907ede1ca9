"""What numba and LLVM are told of kernels."""
