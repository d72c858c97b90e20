"""Real hardware: arms, wrenches, cameras, and the rig that joins them. Each library has one importer."""
