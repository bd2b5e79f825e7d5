"""Studies beside the search: what accuracy costs, what each effect costs, response spectra."""
