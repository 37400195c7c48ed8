"""Figures, tables and one HTML page from labels, solutions and a classifier; and the statements of the paper."""
