"""A lockbox as a MuJoCo model: panel, joints, interlock, appearance."""
