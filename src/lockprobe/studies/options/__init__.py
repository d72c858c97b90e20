"""What a user asks for, as options or in a study file, and the study that it makes."""
