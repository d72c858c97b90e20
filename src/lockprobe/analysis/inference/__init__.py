"""What a study lets one conclude: the paper's statistics, and the tests that are valid."""
