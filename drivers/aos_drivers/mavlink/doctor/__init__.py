"""The command ``aos-gcs doctor``: the traffic that is heard, its diagnosis, and the command itself."""
