"""Hand-eye calibration of a camera on a robot's hand, from pictures of tags on the board."""
