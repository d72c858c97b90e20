"""The lockbox as tools of the Model Context Protocol; clients play the trials of a study one after another."""
