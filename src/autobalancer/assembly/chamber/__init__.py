"""From a machine with deep chambers to the numbers of its kernels."""

from autobalancer.assembly.chamber.assemble import assemble_chamber
from autobalancer.assembly.chamber.contact import contact_time

__all__ = ["assemble_chamber", "contact_time"]
