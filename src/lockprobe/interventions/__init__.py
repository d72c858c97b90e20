"""Interventions at the four places of the loop between agent and box, and the modalities of the box."""
