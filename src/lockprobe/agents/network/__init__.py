"""A small recurrent network that learns in context to open new boxes, and its training."""
