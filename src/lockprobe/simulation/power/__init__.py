"""How many trials a design needs: for tests over flip rates, for conditions, for the study why."""
