"""Studies: their settings, the journal of finished trials, and the runner between them."""

SETTINGS = "study.json"
"""The name of the file in the directory of a study that holds its settings."""

RESULTS, PAGE = "results.json", "report.html"
"""What a report writes there: its rows, and its page."""

PEOPLE_DIRECTORY = "people"
"""The directory in it with the texts and settings with which people take part; what they do is in the store."""

FORKS = "forks"
"""The directory in it with forks of its trials."""
