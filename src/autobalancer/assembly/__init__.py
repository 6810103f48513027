"""The only place where machines and kernels meet: ``Machine -> System``, profile -> segments."""
