"""Files on disk: whole or not there, published as one result, checked by its manifest.

The version that is written into them is here too."""
