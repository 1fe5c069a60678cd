"""Frames from real vehicles, whatever the driver: images, when they were exposed, and from where.

| modules | |
|---|---|
| ``settings``, ``errors``, ``counts`` | which source a vehicle has; why a frame is not used; how often |
| ``track``, ``gimbal``, ``mount``, ``clocks``, ``plausibility`` | the pose at exposure, and whether it can be |
| ``headers``, ``images`` | from a file to an image |
| ``fetching``, ``folder``, ``companion``, ``matching``, ``stores`` | finding the file of an exposure |
| ``photos``, ``stream_clock``, ``video`` | photographs with geotags, and streams |

See docs/frames.md.
"""
