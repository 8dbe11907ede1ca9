"""Datasets: variables, labels, layout, stores, files, provenance, summaries, and the accessor ``pounding``."""

from pounding_risk.results import accessor as accessor  # registers it with xarray
