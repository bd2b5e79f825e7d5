"""Drawing: the cam with its diagrams, and parts of pictures, which the rooms of other results put together."""
