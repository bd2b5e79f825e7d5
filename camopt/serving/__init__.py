"""A scene's page with sliders, served on this machine alone: requests, answers, and the server."""
