"""Drawing: what a picture is made of. ``camopt.figures`` puts it together."""
