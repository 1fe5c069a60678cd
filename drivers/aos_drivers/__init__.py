"""Drivers: implementations of ``aos_gcs.ports`` for real protocols."""
