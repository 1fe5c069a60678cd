"""The command ``aos-gcs doctor``: a survey of what is heard, its diagnosis, and the command itself."""
