"""Disc cam with a groove in its face, whose two walls drive a roller.

The roller's centre moves as over an open disc cam, with the same pressure angle and the same pitch curve. The walls
are R_r from the pitch curve, one on each side. The inner wall pushes the roller outward; its least radius is R_b.
The outer wall pulls the roller back. Every bend of the pitch curve is a hollow of one wall, so |κ|·R_r < 1 has to
hold. The outer wall is farthest from the axis where the trace point C is:

    R_out = max |C| + R_r        (plus half the clearance, if there is one)

Source: Norton, Cam Design and Manufacturing Handbook, ch. 1 (form-closed track cams).
"""

from camopt.model.mechanisms import oscillating, translating
from camopt.model.mechanisms.design import Mechanism
from camopt.model.mechanisms.elements import FACE_GROOVE, FACE_WALLS, GROOVED, ROLLER


def _groove_mechanism_from_open_disc(mechanism: Mechanism) -> Mechanism:
    """The mechanism of an open disc cam, with its pitch curve as the middle of a groove."""
    return mechanism._replace(
        body=FACE_GROOVE,
        drive=GROOVED._replace(flanks=FACE_WALLS),
        tips=(ROLLER,),
        name=f"grooved disc cam, {mechanism.motion.name} follower",
        path=mechanism.sliding,
    )


FACE_GROOVE_MECHANISMS = (
    _groove_mechanism_from_open_disc(translating.MECHANISM),
    _groove_mechanism_from_open_disc(oscillating.MECHANISM),
)
