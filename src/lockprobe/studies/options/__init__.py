"""The settings of a study: options, study files, the settings that a directory holds."""
