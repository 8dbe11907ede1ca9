"""The processing chain of a record: one module for each family of steps."""
