"""The study of searches: whole searches of hectares, by rays, and what they find, when, and at what rate."""
