"""What the perceptron is measured against: nearest neighbours, a support vector machine, a random forest."""

from __future__ import annotations

from sklearn.ensemble import RandomForestClassifier
from sklearn.multiclass import OneVsRestClassifier
from sklearn.neighbors import KNeighborsClassifier
from sklearn.svm import SVC


def nearest_neighbours() -> KNeighborsClassifier:
    """k nearest tasks, each with one vote."""
    return KNeighborsClassifier()


def support_vectors() -> OneVsRestClassifier:
    """A radial-basis support vector machine a gait; their decision values are continuous scores, unlike SVC's votes."""
    return OneVsRestClassifier(SVC(kernel="rbf"))


def random_forest(seed: int) -> RandomForestClassifier:
    """A forest of 100 trees."""
    return RandomForestClassifier(n_estimators=100, random_state=seed, n_jobs=1)
