"""Rendering of a MuJoCo model, with or without OpenGL."""
