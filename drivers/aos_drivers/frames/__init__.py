"""Frames from real vehicles, whatever the driver: images, when they were exposed, and from where.

Poses: ``track`` (interpolation), ``gimbal`` (frames of gimbal attitudes), ``mount`` (from the vehicle to its camera),
``clocks`` (times of vehicles), ``plausibility``. Images: ``headers``, ``images`` (decoding), ``fetching``, ``folder``,
``companion``, ``matching``. Sources: ``reported``, ``photos``, ``video``. See docs/frames.md.
"""
