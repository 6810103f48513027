"""Long steps by exponential collocation: the linear motion exactly, all else as polynomials through the nodes of a step."""
