"""Learning the map from task to gait (section III.C): classifiers, how they are judged, and warm starts."""
