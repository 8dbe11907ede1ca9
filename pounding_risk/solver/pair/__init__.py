"""Compiled solver of a pair of single masses.

In the order in which a run passes through the modules:

- `api` (a run for Python), `grid` (all gaps and yield forces of a law), `run` (flights and contacts in turn)
- flight: `free` (the response without contact), `flight`, `taylor` (search on a Taylor series)
- a contact: `contact`, `equations`, the steps of `explicit` and `implicit`, `events`, `peaks`
- its law: `law_verbs` (how a contact begins, turns and ends in it), `laws` (laws called by address)
- velocities that jump: `impulsive`, `joined` (the motion of both as one)
- `isolated` (one collision alone), `outputs`
"""
