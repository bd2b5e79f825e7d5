"""The smallest cam that meets all limits, with a proof, and what each limit costs.

Start with ``optimise`` (the command), then ``smallest`` (one law, one train), ``branch_and_bound`` and ``prices``.
"""
