"""Configuration of the service: a TOML file, checked once, turned into the core's own settings."""
