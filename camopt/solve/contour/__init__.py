"""The cam's curves as lines, arcs and cubics for machines and other programs, with their proved deviations."""
