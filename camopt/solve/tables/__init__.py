"""Results and their tables: on screen, as HTML, in Parquet files and workbooks; and the scene of each row.

Read ``result`` first: every command returns a ``Result``.
"""
