"""Live pictures of all cameras and of the integral, as small as a wall of tiles needs them, and videos of them."""
