"""Pictures, drawings, pages and files of scenes and results.

In: scenes and results. Out: figures (``drawing``, ``pictures``), workshop drawings (``sheet``), files for other
programs (``exporting``), pages (``reporting``), comparisons (``comparing``), and studies of accuracy and cost
(``studies``). Verdicts and numbers come from ``solve``.

Read first: ``drawing/cam.py``, which draws a cam and its follower.
"""
