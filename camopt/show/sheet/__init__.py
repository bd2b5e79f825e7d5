"""The workshop drawing of a cam: one sheet of A4 or A3 by the conventions of ISO.

Marks (lines and words, in mm on the paper) are made first, view by view. Then the sheet and scale are chosen on
which they fit. Then they are drawn.
"""
