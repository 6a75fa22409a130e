"""A camera that looks down at the ground, and the ground it sees.

soil_texture, ground   brightness of the soil as a function of place and seed, cached in a window
pinhole                poses, and the homography from pixels to the ground
planar, patch          two ways to draw it: projection (default), MuJoCo's renderer through EGL
image                  exposure, vignetting and noise: bytes
frames                 frames drawn or read when asked for; saved as PNG
tracking               frames into velocities on board, one frame at a time

As a sensor, with its epochs, arrivals and mounting, it is `twin.sensors.camera`.
"""
