"""Access control: which requests the service accepts, and from which clients."""
