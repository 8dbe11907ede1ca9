"""Plan of a scan: its cases, size, compilation and time, before it starts."""
