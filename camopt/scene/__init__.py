"""Scenes: the question a user asks, as TOML or a dictionary, checked key by key."""
