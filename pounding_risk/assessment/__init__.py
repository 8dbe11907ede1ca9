"""From a dataset to a verdict: demands, proportions, required gaps, fragility, hazard."""
