"""Maps and planning from them."""
