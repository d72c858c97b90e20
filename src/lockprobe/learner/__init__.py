"""A small recurrent network that learns in context to open boxes it has never seen, and its training."""
