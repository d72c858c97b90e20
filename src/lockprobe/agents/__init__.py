"""Agents: strategies, observers, learners, language models and people, who decide which joint to attempt."""
