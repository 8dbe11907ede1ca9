"""Hard cases, one module a group, found here by `stability`.

A module holds one object ``GROUP``; its cases are the functions decorated with ``GROUP.case`` and the scenes given to
``GROUP.energy``.
"""
