"""Drawing: the cam with its diagrams, and parts of pictures that other parts put together."""
