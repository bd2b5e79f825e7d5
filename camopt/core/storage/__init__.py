"""Files on disk: each is written whole or not at all, results are published at once, and manifests are checked.

``version`` has the version that is written into files.
"""
