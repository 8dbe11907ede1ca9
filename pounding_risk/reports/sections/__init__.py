"""Sections of a report, one module each, with their figures."""
