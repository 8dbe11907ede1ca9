"""Hard cases, found here by `stability`: those of each `Group` of a module.

A group's cases are the functions decorated with ``case`` and the scenes given to ``energy`` and ``energy_of_row``.
"""
