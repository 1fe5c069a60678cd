"""The search: sampling, vision, targets, findings, and the progress of the scan."""
