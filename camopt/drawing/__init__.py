"""Drawing: what a picture is made of. ``camopt.drawing.figures`` puts it together."""
