"""All connected curves of a machine over one or two parameters, as labeled arrays."""
