"""Sections of a report, one module each, found by `document.find_sections`."""
