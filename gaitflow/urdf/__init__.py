"""Single-rigid-body robots from robot descriptions (URDF)."""
