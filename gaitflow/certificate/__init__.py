"""How good a map is, with a guarantee: its picks against the search at random tasks that had no part in making it."""
