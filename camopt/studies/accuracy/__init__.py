"""What accuracy costs in time: sampling, enclosures and balls on the same designs, in one process.

Errors are of what a designer acts on, against ball arithmetic of 200 bits with the laws in closed form. Times are
the least of a few runs, compilation apart, one thread.
"""

from camopt.studies.accuracy.table import ACCURACY, Costs, measure, write_accuracy

__all__ = ["ACCURACY", "Costs", "measure", "write_accuracy"]
