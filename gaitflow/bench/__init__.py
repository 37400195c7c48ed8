"""Benchmarks whose results are committed: each module makes one JSON document."""
