"""Real hardware: arms, force-torque sensors, cameras, and the rig that joins them. Each library has one importer."""
