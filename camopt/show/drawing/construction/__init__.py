"""The construction of a cam with ruler and compasses, as lectures draw it, and its sheet.

A scene and a number of parts come in; steps (a sentence, lines with names, letters) come out, and the sheet draws
them. ``stations.py`` is the file to read first.
"""
