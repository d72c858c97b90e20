"""Language models that are reached through a provider, hosted or on a server of your own."""
