"""From the file of a record to a ground acceleration in m/s²."""
