"""A rotor made of the modes that were fitted to a measured receptance."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autobalancer.assembly.quantities import changed_part
from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine import Machine, ModalRotor, PlanarRotor, Resonance
from autobalancer.rotordynamics.receptance.answer import FittedReceptance
from autobalancer.rotordynamics.receptance.measured import hertz
from autobalancer.units import optional_argument

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
COUPLED = 1.5  # times what a free fit leaves, from which on it is said that the modes are not damped each by itself


class MeasuredRotor(NamedTuple):
    """A rotor, and its receptance beside the measured one."""

    rotor: PlanarRotor | ModalRotor
    fit: FittedReceptance  # with the modes of this rotor


def receptance_rotor(fit: xr.Dataset, *, inertia: float | str | None = None) -> PlanarRotor | ModalRotor:
    """The rotor of a machine from a measured receptance: of one mode a planar rotor, of several a modal one.

    Each mode of this rotor is damped by itself and has a positive mass, so that it can be run; frequencies, damping ratios and
    masses are fitted once more under this condition, each value with the weight of its noise.

    Parameters
    ----------
    fit
        From :func:`receptance`, of a test without balls, or of one whose balls are taken off (``mass_added`` of
        :func:`load_receptance`).
    inertia
        About the shaft, kg m^2; needed only where a torque drives.

    Returns
    -------
    PlanarRotor or ModalRotor
        For the ``rotor`` of a machine.

    Raises
    ------
    QuestionError
        If a mode has no positive mass, so that no such rotor exists.
    """
    return measured_rotor(fit, inertia=inertia).rotor


def measured_rotor(fit: xr.Dataset, *, inertia: float | str | None = None) -> MeasuredRotor:
    """The same with its receptance in place of that of the fit; ``free_error`` is what ``fit`` itself leaves."""
    about = optional_argument("inertia", inertia, "kg*m^2")
    modes = np.array([fit[f"mode_{name}"].values for name in ("mass", "frequency", "damping_ratio")], np.float64)
    if not (modes[0] > 0.0).all():
        where = ", ".join(hertz(float(mode)) for mode in modes[1, ~(modes[0] > 0.0)])
        raise QuestionError(
            f"receptance: the mode at {where} Hz has no positive mass, which no rotor has at the place of the force; look at the "
            "picture, and fit fewer modes or a narrower band"
        )
    modes, error = _damped_by_itself(fit, modes)
    measured_rotor = _with_modes(fit, modes)
    measured_rotor.attrs |= {"fit_error": error, "free_error": fit.attrs["fit_error"]}
    if error > COUPLED * fit.attrs["fit_error"]:
        said = (
            f"modes that are damped each by itself leave {100.0 * error:.2g} % of the values, a free fit "
            f"{100.0 * fit.attrs['fit_error']:.2g} %: the rotor that runs is that much coarser than the measurement"
        )
        measured_rotor.attrs["warnings"] = "\n".join(filter(None, (fit.attrs["warnings"], said)))
    return MeasuredRotor(_rotor(modes, about), FittedReceptance.of(measured_rotor))


def said_of(fit: FittedReceptance) -> str:
    """What was measured and fitted, in one line."""
    modes = zip(*(fit[f"mode_{name}"].values.tolist() for name in ("frequency", "damping_ratio", "mass")), strict=True)
    said = "; ".join(f"{hertz(w)} Hz, damping ratio {100.0 * ratio:.3g} %, mass {m:.4g} kg" for w, ratio, m in modes)
    low, high = (hertz(float(fit.attrs[f"band_{end}"])) for end in ("low", "high"))
    return f"{fit.attrs['title']}, {low} to {high} Hz: {said}; left over {100.0 * float(fit.attrs['fit_error']):.2g} %"


def with_measured_rotor(machine: Machine, measured: MeasuredRotor) -> Machine:
    """A machine with this rotor in place of its own; its description says so.

    Raises
    ------
    QuestionError
        If the machine has what a rotor known in one plane cannot carry.
    """
    try:
        changed: Machine = changed_part(machine, rotor=measured.rotor)
    except MachineError as reason:
        raise QuestionError(
            f"receptance: the machine cannot have a rotor that is known in one plane: {reason}"
        ) from None
    text = f"Its rotor was fitted to {said_of(measured.fit)}. {machine.description}".strip()
    return changed.model_copy(update={"description": text})


def _damped_by_itself(fit: xr.Dataset, modes: Floats) -> tuple[Floats, float]:
    """Masses, frequencies and damping ratios nearest to what was measured, and what they leave of it."""
    used = np.flatnonzero(fit["used"].values)
    frequency, noise = (np.asarray(fit[name].values[used], np.float64) for name in ("frequency", "noise_deviation"))
    measured = np.asarray((fit["receptance_real"].values + 1j * fit["receptance_imag"].values)[used], np.complex128)

    def left(logarithms: Floats) -> Floats:
        miss = (_receptance(np.exp(logarithms).reshape(3, -1), frequency) - measured) / noise
        return np.concatenate([miss.real, miss.imag])

    start = np.log(np.maximum(modes, 1e-9)).ravel()
    best = (
        least_squares(left, start, x_scale="jac").x if modes.shape[1] > 1 else start
    )  # one mode is such a rotor itself
    modes = np.exp(best).reshape(3, -1)
    size = float((np.abs(_receptance(modes, frequency) / noise) ** 2).sum())
    return modes[:, np.argsort(modes[1])], math.sqrt(float((left(best) ** 2).sum()) / size)


def _with_modes(fit: xr.Dataset, modes: Floats) -> xr.Dataset:
    mass, own, ratio = modes
    poles = own * (-ratio + np.sqrt((ratio**2 - 1.0).astype(np.complex128)))
    others = own * (-ratio - np.sqrt((ratio**2 - 1.0).astype(np.complex128)))
    residues = 1.0 / (mass * (poles - others))
    values = _receptance(modes, np.asarray(fit["frequency"].values, np.float64))
    both = {
        "fitted": values,
        "pole": np.concatenate([poles, others]),
        "residue": np.concatenate([residues, -residues]),
    }
    parts = {f"{name}_{part}": getattr(of, part) for name, of in both.items() for part in ("real", "imag")}
    parts |= {"mode_mass": mass, "mode_frequency": own, "mode_damping_ratio": ratio}
    return fit.assign({name: fit[name].copy(data=part) for name, part in parts.items()})


def _rotor(modes: Floats, inertia: float | None) -> PlanarRotor | ModalRotor:
    listed = modes.T.tolist()
    if len(listed) > 1:
        parts = tuple(Resonance(mass=m, frequency=w, damping_ratio=ratio) for m, w, ratio in listed)
        return ModalRotor(resonances=parts, inertia=inertia)
    ((m, w, ratio),) = listed
    return PlanarRotor(mass=m, stiffness=m * w**2, damping=2.0 * ratio * w * m, inertia=inertia)


def _receptance(modes: Floats, frequency: Floats) -> Complexes:
    mass, own, ratio = modes
    sigma = 1j * frequency[:, None]
    return np.asarray((1.0 / (mass * (sigma**2 + 2.0 * ratio * own * sigma + own**2))).sum(axis=1), np.complex128)
