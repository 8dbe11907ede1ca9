"""Datasets: variables, labels, layout, stores, files, provenance, summaries, and the accessor ``pounding``."""
