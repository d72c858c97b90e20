"""A robot arm with hand and force sensor: controller, kinematics, guarded move; simulated or real."""
