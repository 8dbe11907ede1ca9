"""The compiled solver: pure functions on numbers and arrays, and nothing that knows of scenes, records or files."""
