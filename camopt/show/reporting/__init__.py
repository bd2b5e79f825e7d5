"""Pages: a result as one that needs no network; a scene's with sliders, served on this machine alone."""
