"""Rival methods that solve the same pair: fixed steps (three kernels) and SciPy; none is used by a scan."""
