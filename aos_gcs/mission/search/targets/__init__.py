"""Targets: tracks of what is in view, what each is taken for, and what is announced and kept as a finding."""
