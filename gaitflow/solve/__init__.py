"""Solving one task: the fixed-gait NLP, Bonmin, and the search over patterns."""
