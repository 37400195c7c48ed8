"""The stages of a map, the files between them, and the workflow that runs them."""
