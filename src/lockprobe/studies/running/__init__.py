"""Playing the trials of a study: the runner, its workers, one trial at a time."""
