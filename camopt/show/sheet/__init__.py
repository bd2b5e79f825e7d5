"""The workshop drawing of a cam: one sheet of A4 or A3 by the conventions of ISO.

Marks (lines and words, mm on the paper) are made first, view by view; the sheet and the scale on which they fit are
chosen next; what is left is to draw them.
"""
