"""The door for quantities: ``"4.4 g"``, ``"1200 rpm"``, ``"20 mm^2/s"`` to SI and back, and ranges of them.

Inside the package every number is SI: a plain float. At the door a quantity may be a number (already SI) or a
string with a unit. :class:`WrittenFloat` is the float that remembers how it was written, so that a machine that is read
and saved again keeps its author's units.
"""

from autobalancer.units.quantity import WrittenFloat as WrittenFloat
from autobalancer.units.quantity import argument as argument
from autobalancer.units.quantity import column_factor as column_factor
from autobalancer.units.quantity import ends_argument as ends_argument
from autobalancer.units.quantity import field_arguments as field_arguments
from autobalancer.units.quantity import from_si as from_si
from autobalancer.units.quantity import list_argument as list_argument
from autobalancer.units.quantity import option_to_si as option_to_si
from autobalancer.units.quantity import optional_argument as optional_argument
from autobalancer.units.quantity import sample as sample
from autobalancer.units.quantity import samples_of as samples_of
from autobalancer.units.quantity import shortened as shortened
from autobalancer.units.quantity import texts_argument as texts_argument
from autobalancer.units.quantity import to_si as to_si
from autobalancer.units.quantity import unbalance_argument as unbalance_argument
