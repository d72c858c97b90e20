"""Lockprobe on physical boxes: the MuJoCo twin with its robot arm, films, calibration, and adapters of real robots."""
