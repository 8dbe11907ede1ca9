"""Accuracy, baselines, stability, verification: the laboratory. Nothing below or beside it imports it."""
