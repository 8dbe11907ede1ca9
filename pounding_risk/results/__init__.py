"""Datasets: variables, labels, layout, stores, files, provenance, summaries."""
