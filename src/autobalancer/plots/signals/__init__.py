"""Pictures of measured signals: orders, spectra, orbits, decays."""
