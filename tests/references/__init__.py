"""Independent derivations against which the package is tested."""
