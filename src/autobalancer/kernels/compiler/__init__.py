"""All that touches the inside of Numba: how kernels are compiled and called, and where compiled ones are kept."""
