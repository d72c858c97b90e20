"""A user's own MuJoCo model as a plant: read as untrusted data, checked against the rules by pushing."""
