"""Image files: finding the file of an exposure, fetching, decoding and geotags."""
