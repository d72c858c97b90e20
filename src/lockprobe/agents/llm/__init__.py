"""Language models behind a provider's interface, hosted or served on one's own machine."""
