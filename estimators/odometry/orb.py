"""ORB features and their displacements: as the cross-slope paper prints it (a), and done well (b).

Sources: Rublee et al. 2011 (ORB); the paper "GNSS and camera sideslip", section on visual odometry,
equations (17)-(20).
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from estimators.odometry.lens import Array, Picture
from estimators.odometry.match import Match

FEATURES = 500
LEAST_MATCHES = 8
LEAST_INLIERS = 0.25
RANSAC_PX = 1.0
LOCKED_PX = 0.25
"""sd of an error that all matches share: ORB finds corners at whole pixels of each octave, so equal
displacements are all rounded the same way."""
TREES, CHECKS = 5, 50
"""Of FLANN's randomised k-d trees: OpenCV's tutorial's, the paper gives none."""
SEED = 1


def match_similarity(
    previous: Picture, current: Picture, turn_rad: float, moved_px: Array | None = None
) -> Match | None:
    """(b) Hamming matches that are mutual best, and a RANSAC similarity through them.

    Neither gyro nor motion is needed: the similarity has the rotation. The variance is that of a
    mean over the inliers, of residuals about the similarity, and of whole pixels.
    """
    found = _features(previous, current)
    if found is None:
        return None
    before, after, words_before, words_after = found
    pairs = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(words_after, words_before)
    if len(pairs) < LEAST_MATCHES:
        return None
    now, then = _ends(pairs, after, before)
    cv2.setRNGSeed(SEED)  # RANSAC draws from OpenCV's one generator
    warp, mask = cv2.estimateAffinePartial2D(
        now, then, method=cv2.RANSAC, ransacReprojThreshold=RANSAC_PX
    )
    inside: NDArray[np.bool_] = np.asarray(mask, bool).reshape(
        -1
    )  # all False where there is no warp
    count = int(inside.sum())
    if count < max(LEAST_MATCHES, LEAST_INLIERS * len(pairs)):
        return None
    left = then[inside] - (now[inside] @ warp[:, :2].T + warp[:, 2])
    spread = float((left * left).sum()) / max(2 * count - 4, 1)
    return Match(
        previous_from_current=np.asarray(warp, np.float64),
        variance_px2=spread / count + LOCKED_PX**2,
        quality=count / len(pairs),
    )


def match_printed(
    previous: Picture, current: Picture, turn_rad: float, moved_px: Array | None = None
) -> Match | None:
    """(a) Euclidean FLANN matches, 2-means on their distances, mean displacement of the nearer.

    As printed: the bits of a descriptor are taken as 32 coordinates, distances (17) are clustered
    (18), and the mean displacement d at angle theta is the camera's (19)-(20). There is no model of
    rotation, and nothing says which matches are wrong. The number of clusters is not printed; two
    is the least that leaves any out. The variance is the mean's, and is as unaware.
    """
    found = _features(previous, current)
    if found is None:
        return None
    before, after, words_before, words_after = found
    flann = cv2.FlannBasedMatcher({"algorithm": 1, "trees": TREES}, {"checks": CHECKS})
    cv2.setRNGSeed(SEED)
    pairs = flann.match(words_after.astype(np.float32), words_before.astype(np.float32))
    if len(pairs) < LEAST_MATCHES:
        return None
    near = _nearer(np.array([[pair.distance] for pair in pairs], np.float32))
    now, then = _ends(pairs, after, before)
    moved = (then - now)[near]
    d_px = moved.mean(axis=0)
    return Match(
        previous_from_current=np.column_stack([np.eye(2), d_px]),
        variance_px2=float(moved.var(axis=0).mean()) / len(moved),
        quality=len(moved) / len(pairs),
        turns=False,
    )


def _nearer(distance: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Which matches are in the cluster of the smaller distance; shape (n,)."""
    until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 20, 1e-3)
    guess = np.zeros((len(distance), 1), np.int32)
    _, label, centre = cv2.kmeans(distance, 2, guess, until, 1, cv2.KMEANS_PP_CENTERS)
    return np.asarray(label.reshape(-1) == int(np.argmin(centre)), np.bool_)


Found = tuple[Any, Any, NDArray[np.uint8], NDArray[np.uint8]]


def _features(previous: Picture, current: Picture) -> Found | None:
    """Key points and descriptors of both pictures, or None where one has too few."""
    orb = cv2.ORB.create(nfeatures=FEATURES, fastThreshold=7)
    before, words_before = orb.detectAndCompute(_bytes(previous), None)
    after, words_after = orb.detectAndCompute(_bytes(current), None)
    if min(len(before), len(after)) < LEAST_MATCHES:  # without any, the words are None
        return None
    return before, after, np.asarray(words_before), np.asarray(words_after)


def _bytes(picture: Picture) -> NDArray[np.uint8]:
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _ends(pairs: Any, after: Any, before: Any) -> tuple[Array, Array]:
    """Where each match is now and was before, shape (n, 2) each."""
    now = np.array([after[pair.queryIdx].pt for pair in pairs])
    then = np.array([before[pair.trainIdx].pt for pair in pairs])
    return now, then
