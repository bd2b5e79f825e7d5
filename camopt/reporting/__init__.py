"""A result as one page that needs no network: what is in it, and the file."""
