"""A measure."""


def untold(trial):
    """Share of attempts of which nothing was told, [0, 1]."""
    if not trial.steps:
        return None
    return sum(step.told_moved is None for step in trial.steps) / len(trial.steps)
