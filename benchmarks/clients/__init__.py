"""What robots' programs make of a map's plans."""
