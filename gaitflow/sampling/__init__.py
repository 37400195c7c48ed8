"""Choosing tasks where a map is least sure, in rounds, until its certificate says that it is good."""
