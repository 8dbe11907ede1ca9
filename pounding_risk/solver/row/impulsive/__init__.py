"""A run of single masses in a row whose velocities jump at a touch: exact motion between jumps, and contacts at rest.

Each building is written down at its own events alone: what happens elsewhere in the row does not change a bit of it.
"""
