"""Run a command and print its peak memory in MiB: ``python peak_memory.py COMMAND …``.

A process of its own, because a child's peak starts at that of the process it was split from.
"""

import os
import subprocess
import sys

if __name__ == "__main__":
    process = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    unit = 2**20 if sys.platform == "darwin" else 2**10
    print(usage.ru_maxrss / unit)
    sys.exit(os.waitstatus_to_exitcode(status))
