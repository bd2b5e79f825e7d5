"""The commands: what each takes, the call of the library that it makes, and what it prints."""
