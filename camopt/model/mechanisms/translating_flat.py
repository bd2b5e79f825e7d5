"""Disc cam, translating flat-faced follower; the face is square to the motion.

    ρ = R_b + y + y'',    contact at y' from the cam centre along the face,    β = 0,    sliding at R_b + y per rad

Source: Norton, Cam Design and Manufacturing Handbook, ch. 7.
"""

from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import Linear
from camopt.model.mechanisms.contact_errors import ContactErrors, ContactPoint, ContactShift
from camopt.model.mechanisms.design import Designs, Mechanism, with_zero_cam_size
from camopt.model.mechanisms.elements import DISC, FLAT, SPRUNG, TRANSLATING
from camopt.model.motion.profile_contact import TranslatingFace


def _linear_curve(designs: Designs, y: float, y1: float, y2: float, constant: FloatArray) -> Linear:
    """The curve y·(displacement) + y1·(velocity) + y2·(acceleration) + constant."""
    zeros = np.zeros(len(designs))
    return Linear(zeros + y, zeros + y1, zeros + y2, zeros + constant)


def _flat_face_contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
    return ContactPoint(y1 * design.sense, y + design.size, y * 0.0, y * 0.0 + 1.0)


def _flat_face_shifted_contact(
    design: Designs, lift: float, y: Any, y1: Any, errors: ContactErrors
) -> ContactShift:
    """The tilted face is at the distance R_b + y + δn from the axis; the stem moves where the face crosses it."""
    point, half = _flat_face_contact(design, lift, 0.0, y, y1), np.sin(errors.tilt * 0.5)
    stem, sine, cosine = design.offset + errors.size_error("offset"), np.sin(errors.tilt), np.cos(errors.tilt)
    moved = (errors.flat_face_profile_error(point) + stem * sine + np.square(half) * 2.0 * point.y) / cosine
    return ContactShift(moved, errors.tilt * design.sense + y1 * 0.0)


MECHANISM = Mechanism(
    body=DISC,
    drive=SPRUNG,
    motion=TRANSLATING,
    tips=(FLAT,),
    sizes=("offset",),
    name="disc cam, translating flat-faced follower",
    pressure=lambda designs, programme: _linear_curve(designs, 0, 0, 0, np.zeros(1)),
    profile_radius=lambda designs, programme: _linear_curve(designs, 1, 0, 1, designs.size),
    sliding=lambda designs, programme: _linear_curve(designs, 1, 0, 0, designs.size),
    reach=lambda designs, programme: _linear_curve(designs, 0, 1, 0, -designs.signed_offset),
    outline=lambda designs, programme, beyond: _linear_curve(designs, 1, 0, 0, designs.size),
    assembly_margins=lambda designs, programme: (designs.size * 0.0 + 1.0,),
    assembly="the base radius has to be above 0",
    contact=_flat_face_contact,
    shifted_contact=_flat_face_shifted_contact,
    pitch=with_zero_cam_size,
    parallel="size",
    on_profile=lambda sizes, sense: TranslatingFace(),
)
