"""The store, the workers and what is left when they are killed."""
