"""The folder in which a scan keeps what it has solved, so that it can go on after a stop."""
