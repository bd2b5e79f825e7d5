"""The cost of accuracy: sampling, enclosures and 50 digits on the same designs, in one process.

Errors are those of quantities that a designer uses, against the same formulas with 50 digits. Times are the
smallest CPU times of a few runs in one thread, without compilation.
"""

from camopt.show.studies.accuracy.table import ACCURACY, AccuracyCosts, measure_accuracy_costs, write_accuracy

__all__ = ["ACCURACY", "AccuracyCosts", "measure_accuracy_costs", "write_accuracy"]
