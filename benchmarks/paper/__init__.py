"""The tables of the paper, and what its formulation costs."""
