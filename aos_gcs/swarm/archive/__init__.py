"""The archive strategy: views of the target, kept and combined."""
