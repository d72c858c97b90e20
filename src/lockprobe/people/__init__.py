"""People as agents: consent, assignment, scenes and acts, stored durably. No HTTP here."""
