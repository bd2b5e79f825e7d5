"""The cam for other programs, machines and people: files of drawings, solids, points and tables."""
