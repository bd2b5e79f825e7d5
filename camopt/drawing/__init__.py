"""Drawing: the parts of pictures. ``camopt.drawing.figures`` puts them together."""
