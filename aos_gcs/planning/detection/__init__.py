"""What a search is expected to see: views of each place, and plans for a wanted probability of detection."""
