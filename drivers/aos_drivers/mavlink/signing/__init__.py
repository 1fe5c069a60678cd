"""Signatures of MAVLink 2: keys on disk, keys per link, signing and checking packets."""
