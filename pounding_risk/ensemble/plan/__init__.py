"""Plan of a scan: its cases, size and time, before it starts."""
