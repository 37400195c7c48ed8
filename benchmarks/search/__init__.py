"""How the search for a gait fares: against exhaustive search, and by size."""
