"""Files on disk: whole or not there, published as one result, tables with a seal, records, and checks of all.

The version that is written into them is here too."""
