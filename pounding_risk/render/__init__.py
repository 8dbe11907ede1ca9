"""Sheets, and what shows them: every number of an answer becomes text here.

A sheet is a list of blocks (`sheet`): paragraphs, lists, tables and figures, whose cells keep the value beside
its text. `terminal` prints one; the report's page and PDF show the same blocks.
"""
