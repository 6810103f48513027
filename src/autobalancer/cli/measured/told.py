"""An answer of the group on the screen: its facts, its table, its remarks; or as JSON or CSV."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalancer.cli.terminal.words import note

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.results.answers.answer import Answer


def tell(found: Answer, as_json: bool, as_csv: bool) -> None:
    """Print it in the form that was asked for."""
    from autobalancer.cli.terminal.output import one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet
    from autobalancer.results.export import plain_json

    one_form(as_json, as_csv)
    if as_json:
        values = {str(name): entry.values.tolist() for name, entry in found.variables.items()}
        print_json(plain_json(values | {"remarks": list(found.remarks())}))
    elif as_csv:
        print_csv(found.columns())
    else:
        if found.facts():
            print_facts(list(found.facts()), found.heading())
        print_sheet(found.columns(), "" if found.facts() else found.heading())
        for text in found.remarks():
            note(text)


def tell_signals(found: xr.Dataset, as_json: bool, as_csv: bool) -> None:
    """Print the channels of signals, not their samples, in the form that was asked for."""
    from autobalancer.cli.terminal.output import print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet

    if as_json:
        about = {"sampling_rate": found.attrs["sampling_rate"], "samples": found.sizes["time"]}
        print_json(about | {"channels": {str(name): entry.attrs for name, entry in found.data_vars.items()}})
    elif as_csv:
        print_csv(found.columns())
    else:
        print_facts(found.facts(), found.heading())
        print_sheet(found.columns())
