"""Rows and tables of designs: columns, units, Parquet files that say whether they are whole."""
