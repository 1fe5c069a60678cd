"""``python -m aos_gcs`` is the command ``aos-gcs``."""

from aos_gcs.cli import main

main()
