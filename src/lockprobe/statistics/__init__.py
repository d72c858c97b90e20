"""Analysis of trials: every number that a study reports, and the tests behind its conclusions."""
