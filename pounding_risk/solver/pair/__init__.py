"""Compiled solver of a pair of single masses."""
