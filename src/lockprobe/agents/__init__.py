"""Agents: strategies, observers, language models and people, who decide which joint to attempt."""
