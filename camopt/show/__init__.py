"""What people look at and machines read: pictures, drawings, pages, files.

In: scenes and results. Out: figures (``drawing``, ``pictures``), workshop drawings (``sheet``), files for other
programs (``exporting``), pages (``reporting``), comparisons (``comparing``), and studies of accuracy and cost
(``studies``). Nothing here decides about a design.

Read first: ``drawing/cam.py``, which draws a cam and its follower.
"""
