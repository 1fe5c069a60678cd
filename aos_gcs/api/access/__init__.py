"""Which requests the service accepts, and from whom."""
