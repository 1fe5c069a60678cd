"""Frames from real vehicles, whatever the driver: images, their times of exposure and their poses.

| modules | |
|---|---|
| ``settings`` | the source of each vehicle's frames |
| ``errors`` | reasons for not using a frame, and counts |
| ``poses`` | the pose at exposure, and its plausibility |
| ``files`` | from the file of an exposure to an image |
| ``stream`` | video streams |

See docs/frames.md.
"""
