# written by tools/write_stubs.py from public_names.py

from autobalancer.results.archive import Archive as Archive
from autobalancer.results.chamber_measures import unbalance_of as unbalance_of
from autobalancer.simulation.chamber.bounds import bounds as bounds
from autobalancer.studies.chamber_study import amplitudes as amplitudes
from autobalancer.studies.chamber_study import archived_run as archived_run
from autobalancer.studies.chamber_study import optimal_means as optimal_means
from autobalancer.studies.chamber_study import over_seeds as over_seeds
from autobalancer.studies.chamber_study import pick_up_borders as pick_up_borders
from autobalancer.studies.chamber_study import step_size as step_size
from autobalancer.studies.chamber_study import variant as variant
from autobalancer.studies.design.chambers import design_sensitivity as design_sensitivity

__all__ = [
    "Archive",
    "amplitudes",
    "archived_run",
    "bounds",
    "design_sensitivity",
    "optimal_means",
    "over_seeds",
    "pick_up_borders",
    "step_size",
    "unbalance_of",
    "variant",
]
