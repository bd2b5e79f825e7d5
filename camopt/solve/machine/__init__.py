"""Machines: several cams on one shaft, their clearances, their torque and their speed.

In: a ``Machine``. Out: the ``MachineEvaluation`` with its tables. Read first: ``stations.py``, which turns each
scene into curves over a turn of the machine's shaft.
"""
