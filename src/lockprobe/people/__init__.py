"""People as agents: who takes part, what they are shown, what they do, and that none of it is lost. No HTTP here."""
