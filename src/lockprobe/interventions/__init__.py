"""Interventions at the four places of the loop between agent and box, and how the box is shown."""
