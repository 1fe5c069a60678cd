"""Priors: probability maps and last known points of the missing person, from the files of operators."""
