"""The row solver: any number of storey buildings in a row, and every contact between neighbours.

In the order in which a run passes through the modules:

- what it works on: `workspace` (arrays, and what each of their rows is), `layout` (from buildings and contact points to
  arrays), `ground` and `ground_dof` (the motion under each building), `api` (a run for Python)
- one building: `building` (equations, Taylor series), `storey` (yielding), `node_map` (a node interval by a map)
- flight: `contact_points`, `flight_by_map` and `flight_by_series`, `flight_peaks`
- without any contact: `free_motion` with `free_buildings` and `free_distances`, from the state of `initial_state`
- a run: `run`, `blocks` (what need not be looked at), `interval`, `saved_state`, `group` (neighbours that touch)
- in contact: `contact`, `laws`, `equations`, the steps of `explicit` and `implicit`, `event_functions` and `events`,
  `local_maxima` and `peaks`
- a log of a run: `trace`, read by `trace_reader`
- velocities that jump: `impulsive`, with `complementarity`
- many runs: `model`, `partition`, `cases`, `outputs`
"""
