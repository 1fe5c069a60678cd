"""The commands ``aos-gcs lab``."""
