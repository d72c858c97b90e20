"""What a study directory holds: the journal, records, pictures, and how parts are merged."""
