"""The atlas of a map, grown from its dataset: gaits solved at tasks, with their tangents."""
