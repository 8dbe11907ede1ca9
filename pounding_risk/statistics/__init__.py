"""Numbers in, numbers out: proportions, required gaps, fragilities, annual rates, Sobol indices, crossed factors.

Nothing here knows a dataset, and each method names its source. A fit that is refused carries the sentence that an
exception would.
"""
