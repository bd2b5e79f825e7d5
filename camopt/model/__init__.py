"""The mechanics of a cam: its motion, its contact with the follower, and the quantities that follow from them.

In: laws, sizes, numbers of the load. Out: curves over the cam angle, and their peaks and means. Parts: ``trains``
(the linkage between follower and tool), ``motion`` (laws and the motion of a whole turn), ``mechanisms`` (cam and
follower), ``effects`` (quantities). A part imports only from those before it.

Read first: ``mechanisms/translating.py``, the formulas of a disc cam with a translating follower.
"""
