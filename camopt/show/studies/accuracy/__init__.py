"""What accuracy costs in time: sampling, enclosures and 50 digits on the same designs, in one process.

Errors are of what a designer acts on, against the same formulas on numbers of 50 digits. Times are the least of a
few runs, compilation apart, one thread.
"""

from camopt.show.studies.accuracy.table import ACCURACY, AccuracyCosts, measure, write_accuracy

__all__ = ["ACCURACY", "AccuracyCosts", "measure", "write_accuracy"]
