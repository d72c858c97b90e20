"""What can be changed between a box and an agent: interventions at the four places of the loop, and how it is shown."""
