"""Recorded videos: the track that a drone writes beside its pictures, and frames with poses made of both."""
