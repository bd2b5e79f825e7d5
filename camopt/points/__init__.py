"""The cam as points for machines and other programs."""
