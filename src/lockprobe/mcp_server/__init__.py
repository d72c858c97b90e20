"""The lockbox as tools of the Model Context Protocol, one trial of a study after another."""
