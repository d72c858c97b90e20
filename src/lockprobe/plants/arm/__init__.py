"""A robot arm with hand and force sensor, simulated or real."""
