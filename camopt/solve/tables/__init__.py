"""Tables of designs: columns with units and symbols, cells, workbooks, and the scene of each row."""
