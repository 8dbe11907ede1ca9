"""Hard cases, one module a group."""
