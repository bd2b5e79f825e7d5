"""The workshop drawing of a cam: one sheet, by the conventions of ISO (A4, A3) or of ASME (A to D).

Marks (lines and words, in mm on the paper) are made first, view by view. Then the sheet and scale are chosen on
which they fit. Then they are drawn.
"""
