"""The participants' page and its server; the only importer of the web framework."""
