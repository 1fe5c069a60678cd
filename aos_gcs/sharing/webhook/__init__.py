"""Signed messages about findings and alerts, for programs of others."""
