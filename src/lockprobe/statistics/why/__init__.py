"""Through what a false report acts: arms, contrasts, the rule that names a mechanism."""
