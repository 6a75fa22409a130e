"""Visual odometry of a camera that looks down: frames and gyros in, body-frame velocity out.

Three matchers under one state machine (`odometry.METHODS`):

    orb-printed      ORB, Euclidean FLANN, 2-means on the distances: the paper's, a baseline
    orb-similarity   ORB, Hamming distance, RANSAC similarity
    phase-ecc        gyro-derotated phase correlation, refined by ECC: the recommended

`odometry.step` takes one frame at a time; `streams.run` a chunk of streams. Both say of each frame
whether it was used and why not; a frame that cannot be used never ends a run.
"""
