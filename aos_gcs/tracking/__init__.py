"""Targets over time: from positions with covariances to tracks."""
