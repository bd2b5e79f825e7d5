"""The cam's curves as lines, arcs and cubics that a machine or another program takes, and how far they are off."""
