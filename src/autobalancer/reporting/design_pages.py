"""Pages of a design: what was asked, what ran, which limits this machine keeps, and what was ruled out and why."""

from __future__ import annotations

import json

import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.plots.studies.design import design as design_picture
from autobalancer.reporting.page import Paragraph, Rows, Section, columns_table, drawing, facts
from autobalancer.studies.design.answer import Designed
from autobalancer.studies.design.chosen import designed_machine

SHOWN = {"m": ("mm", 1e3), "kg m": ("g mm", 1e6), "s": ("s", 1.0)}
WIDTH = 24  # designs in the table


def design_pages(found: Designed, machine: Machine, file: str) -> list[Section]:
    """The design from which a machine was chosen.

    Raises
    ------
    QuestionError
        If the machine is none of its designs.
    """
    command = f"autobalancer design {found.attrs['design_name']}.toml"
    place = _place(found, machine)
    page = Section(f"Design {found.attrs['design_name']}", replay=f"{command}  # written to {file}")
    page.blocks += [Paragraph(f"This machine is place {place} of {found.best().sizes['design']}.", strong=True)]
    page.blocks += [facts(found.facts()), columns_table(found.isel(design=found.order()[:WIDTH]).columns("rpm"))]
    page.blocks.append(Paragraph(f"{found.remarks()[0]}."))
    page.blocks.append(
        drawing(
            design_picture(found, title=""), "Candidates that each question ruled out; objectives of those that ran."
        )
    )
    out = Section("What was ruled out, and why", [Paragraph(text) for text in found.reasons()], command)
    return [page, _limits(found, place), *([out] if out.blocks else [])]


def _place(found: Designed, machine: Machine) -> int:
    text = machine_text(machine)
    for place in range(1, found.best().sizes["design"] + 1):
        if machine_text(designed_machine(found, place)) == text:
            return place
    raise QuestionError(
        f"study: this machine is no design of {found.attrs['design_name']!r}; take a machine file that it wrote"
    )


def _limits(found: Designed, place: int) -> Section:
    """The limits, what the chosen design reaches, and the share of its runs beyond with its interval."""
    one = found.isel(design=found.order()[place - 1])
    page, rows = Section("Limits of the design"), []
    for name, value in json.loads(found.attrs["limits"]).items():
        words = name.replace("_", " ")
        if name in found and f"{name}_over" in found:
            sign, factor = SHOWN[found[name].attrs["units"]]
            rows.append(
                (
                    words,
                    f"{factor * value:.4g} {sign}",
                    f"{factor * float(one[name]):.4g} {sign}",
                    _share(one, f"{name}_over"),
                )
            )
        elif name == "stall_probability":
            rows.append((words, f"{100.0 * value:.3g} %", f"{100.0 * float(one['stall']):.3g} %", _share(one, "stall")))
        elif name == "border_margin":
            speed = max(float(one["release"]), float(one["border"]))
            reached = min(found.attrs["speeds"]) / speed - 1.0 if speed > 0.0 else float("nan")
            rows.append((words, f"{100.0 * value:.3g} %", f"{100.0 * reached:.3g} %", "-"))
        elif name == "contact_pressure":
            rows.append((words, f"{1e-6 * value:.0f} MPa", f"{1e-6 * float(one['pressure']):.0f} MPa", "-"))
    head = ("limit", "asked", "reached", "share of the runs beyond it, 95 % interval")
    page.blocks.append(Rows(head, tuple(rows), (False, True, True, False)))
    return page


def _share(one: xr.Dataset, name: str) -> str:
    share, low, high = (100.0 * float(one[f"{name}{end}"]) for end in ("", "_low", "_high"))
    return f"{share:.3g} % ({low:.2g} to {high:.2g} %)"
