"""The atlas of a map: grown from the dataset along the central path, and the predictors made of it."""
