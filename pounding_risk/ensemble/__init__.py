"""The grid of a scene as work: jobs, chunks, threads, Dask, checkpoints, plans."""
