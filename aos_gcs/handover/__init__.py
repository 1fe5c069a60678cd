"""Hand-over of a mission on paper: what was searched, found, decided and flown."""
