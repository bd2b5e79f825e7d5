"""What the rest is built on: it knows no cams.

In: functions, numbers, files. Out: compiled kernels, intervals and exact extremes, parallel work, files written
whole, and the lists of quantities and keys. ``mistakes`` has the errors that users see. Parts: ``kernels`` (machine
code), ``numerics`` (mathematics), ``quantities`` (names and units), ``storage`` (files), ``engines`` (threads to
clusters).

Read first: ``numerics/extremes.py``, which finds the exact extreme of a curve.
"""
