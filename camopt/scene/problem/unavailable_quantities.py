"""Mistakes for limits and outputs that a mechanism does not have, or for which a scene lacks data."""

from collections.abc import Iterator

import numpy as np

from camopt.core.mistakes import Mistake, suggest_names
from camopt.core.quantities import EVERYTHING, QUANTITIES
from camopt.core.quantities.own_quantity import OWN_EFFECT
from camopt.model.effects import Setup, available_quantities, find_quantity, missing_keys_by_quantity, preload
from camopt.model.mechanisms.pairs import HALVES_HAVE_TO, SAME_HALVES, largest_half_turn_misfit
from camopt.model.motion.programme import Programme
from camopt.scene.problem.limits import SINGLE_QUANTITY_KEYS, limited_quantity_name
from camopt.scene.problem.rows import VERDICT_COLUMNS
from camopt.scene.scene import Scene

CONTACT_KEEPING_EFFECTS, CONTACT_KEEPING_QUANTITIES = ("force", "clearance"), ("contact_force_elastic_min_N",)
"""Effects and quantities of contacts that a spring or a groove keeps."""


def unavailable_limits(scene: Scene, setup: Setup) -> list[Mistake]:
    """Mistakes for limits on quantities that the mechanism does not have, or for which keys are missing."""
    mistakes, offers, lacks = [], available_quantities(setup), missing_keys_by_quantity(setup)
    for key, bound in scene.limits.bounds_by_key.items():
        name = limited_quantity_name(key, setup)
        if key in SINGLE_QUANTITY_KEYS and name not in offers:
            why = f"needs {', '.join(lacks[name])}" if name in lacks else _no_such_quantity_message(name, setup)
            mistakes.append(Mistake(scene.file, f"limits.{key}", bound, why, bare=True))
    return mistakes


def _no_such_quantity_message(name: str, setup: Setup) -> str:
    """The message for a quantity that a mechanism does not have; with two contacts, it names the preload."""
    none = f"this mechanism has no {name}"
    if not setup.mechanism.further_contacts or (
        QUANTITIES[name].effect not in CONTACT_KEEPING_EFFECTS and name not in CONTACT_KEEPING_QUANTITIES
    ):
        return none
    how = "its contacts stay closed by a preload"
    return f"{none}: {how} (drive.interference, drive.stiffness); set limits.{preload.PRELOAD_RATIO} = 1"


def unavailable_outputs(scene: Scene, setup: Setup) -> list[Mistake]:
    """Mistakes for outputs and objectives that the mechanism does not have, or for which keys are missing."""
    offers, lacks = (*available_quantities(setup), *VERDICT_COLUMNS), missing_keys_by_quantity(setup)
    numbers = tuple(name for name in offers if find_quantity(name, setup).kind is float)
    effects = {find_quantity(name, setup).effect for name in (*offers, *lacks)}
    named = {
        "outputs": (scene.outputs, (*offers, *effects, EVERYTHING)),
        "search.minimise": (scene.search.minimise, numbers),
        "search.maximise": (scene.search.maximise, numbers),
    }
    mistakes = [*_uncomputable_own_quantities(scene, setup)]
    for key, (names, allowed) in named.items():
        for name in names:
            if name in setup.own_quantities:
                continue
            if name in lacks:
                mistakes.append(Mistake(scene.file, key, name, f"needs {', '.join(lacks[name])}", bare=True))
            elif name not in allowed:
                known = suggest_names(name, [n for n in allowed if n in QUANTITIES or n in setup.own_quantities])
                mistakes.append(Mistake(scene.file, key, name, f"a quantity of this scene; {known}"))
    return mistakes


def _uncomputable_own_quantities(scene: Scene, setup: Setup) -> Iterator[Mistake]:
    """Mistakes for quantities that the scene defines over quantities that cannot be computed."""
    offers, lacks = available_quantities(setup), missing_keys_by_quantity(setup)
    for name, own in setup.own_quantities.items():
        for read in own.quantities_read:
            if read not in offers and read not in setup.own_quantities:
                why = f"needs {', '.join(lacks[read])}" if read in lacks else "is not a quantity of this mechanism"
                value = scene.quantities[name].value
                yield Mistake(scene.file, f"{OWN_EFFECT}.{name}", value, f"{read} {why}", bare=True)


def yoke_motion_mistakes(scene: Scene, motion: Programme) -> list[Mistake]:
    """A mistake if the motion does not fit a yoke."""
    if (
        not scene.mechanism.drive.one_disc
        or (misfit := largest_half_turn_misfit(motion)).off <= SAME_HALVES * motion.lift
    ):
        return []
    how = "Exchange rises and returns in the second half of the turn, with the same angles and laws"
    off = f"the error is {misfit.off:.4g} mm at {np.degrees(misfit.at):.5g} deg"
    return [Mistake(scene.file, "motion", None, f"{HALVES_HAVE_TO}; {off}. {how}", bare=True)]
