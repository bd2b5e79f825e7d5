"""The exact contact of a cut cam with a follower whose sizes are off, at 40 digits, without linearisation.

The profile is that of the nominal design, from ``naive``, moved along its normal and off its axis. At a cam angle
the follower is where it touches it: two equations for the place on the profile and for the displacement.
"""

from typing import Any

from mpmath import mp

from support import naive

Errors = dict[str, Any]
"""In mm and rad: sizes of the follower by key, ``profile`` (with ``waves`` a + ib, as a·cos nφ + b·sin nφ),
``phase``, ``face_tilt``, and ``bore`` as a complex number in the cam's own frame."""


def displacement(scene: dict[str, Any], errors: Errors, theta: Any) -> Any:
    """The displacement of the follower at a cam angle, mm or rad."""
    turned = theta + errors.get("phase", 0)
    solve = _face if scene["follower"]["contact"] == "flat" else _point
    return solve(scene, errors, turned)


def _jet(scene: dict[str, Any], phi: Any) -> Any:
    pieces = naive.programme(scene["motion"], mp, scene["follower"]["motion"] == "oscillating")
    return next(each.jet for each in pieces if each.start <= phi <= each.end)(phi)


def _size(scene: dict[str, Any], errors: Errors, key: str) -> Any:
    return mp.mpf(scene["follower"].get(key, 0)) + errors.get(key, 0)


def _profile_error(errors: Errors, phi: Any) -> Any:
    """How far the profile stands out along its normal."""
    return (mp.conj(errors.get("profile", 0)) * mp.expj(errors.get("waves", 0) * phi)).real


def _solve_pair(equations: Any, theta: Any, y: Any) -> Any:
    """The second of two unknowns, by Newton's method with differences."""
    at, step = mp.matrix([theta, y]), mp.mpf(10) ** (-mp.dps // 2)
    for _ in range(12):
        value = mp.matrix(equations(*at))
        ahead = [mp.matrix(equations(at[0] + step, at[1])), mp.matrix(equations(at[0], at[1] + step))]
        slopes = mp.matrix([[(each[row] - value[row]) / step for each in ahead] for row in range(2)])
        moved = mp.lu_solve(slopes, -value)
        at += moved
        if mp.norm(moved) < mp.mpf(10) ** (4 - mp.dps):
            return at[1]
    raise ValueError("the follower does not come to rest on the profile")


def _point(scene: dict[str, Any], errors: Errors, theta: Any) -> Any:
    """A roller, edge or spherical face: its centre is as far from the profile as its radius."""
    radius_off = sum(errors.get(key, 0) for key in ("roller_radius", "face_radius"))
    developed, sigma = scene["cam"]["form"] == "cylindrical", naive.spin(scene)
    curve = naive.developed_curve if developed else naive.pitch_curve
    bore = errors.get("bore", mp.mpc(0)) * mp.expj(-sigma * theta)
    arm, end = _size(scene, errors, "arm_length"), naive.swing_middle(scene)

    def follower(y: Any) -> Any:
        """The centre in the ground frame; on a cylinder the surface turns by below it."""
        if scene["follower"]["motion"] == "translating":
            radius = naive.number(scene["cam"].get("base_radius", 0), mp) + naive.follower_radius(scene)
            offset = mp.mpf(scene["follower"].get("offset", 0))
            start = 0 if developed else mp.sqrt(radius**2 - offset**2)
            return mp.mpc(_size(scene, errors, "offset"), start + y)
        if developed:
            nominal = mp.mpf(scene["follower"]["arm_length"])
            return -sigma * nominal * mp.cos(end) + arm * mp.mpc(sigma * mp.cos(y - end), mp.sin(y - end))
        return _size(scene, errors, "centre_distance") - arm * mp.expj(-(naive.psi_start(scene) + y))

    def equations(phi: Any, y: Any) -> tuple[Any, Any]:
        p, p1, *_ = curve(scene, mp, phi, _jet(scene, phi))
        off = radius_off + _profile_error(errors, phi)
        normal = p1 * mp.mpc(0, 1 if developed else -sigma) / abs(p1)
        if developed:
            radius = mp.mpf(scene["cam"]["mean_radius"])
            apart = p + off * normal + bore.real - (radius * theta + follower(y))
        else:
            apart = mp.expj(-sigma * theta) * (p + off * normal) + bore - follower(y)
        return apart.real, apart.imag

    return _solve_pair(equations, theta, _jet(scene, theta)[0])


def _face(scene: dict[str, Any], errors: Errors, theta: Any) -> Any:
    """A flat face: a line that touches the profile, whose support function is that of the nominal one."""
    sigma, tilt = naive.spin(scene), errors.get("face_tilt", 0)
    bore = errors.get("bore", mp.mpc(0)) * mp.expj(-sigma * theta)
    base = naive.number(scene["cam"]["base_radius"], mp)
    swings = scene["follower"]["motion"] == "oscillating"
    start = naive.psi_start(scene) if swings else 0

    def equations(phi: Any, y: Any) -> tuple[Any, Any]:
        seen = _jet(scene, phi)[0]
        if swings:
            across, seen_across = mp.pi / 2 - (start + y), mp.pi / 2 - (start + seen)
            c, f = _size(scene, errors, "centre_distance"), _size(scene, errors, "face_offset")
            reached = f + c * mp.sin(start + y)
            nominal = mp.mpf(scene["follower"]["face_offset"])
            support = nominal + mp.mpf(scene["follower"]["centre_distance"]) * mp.sin(start + seen)
        else:
            across, seen_across = mp.pi / 2 + tilt, mp.pi / 2
            place = mp.mpc(_size(scene, errors, "offset"), base + y)
            reached = (place * mp.expj(-across)).real
            support = base + seen
        standing = (bore * mp.expj(-across)).real + _profile_error(errors, phi)
        return sigma * (phi - theta) + seen_across - across, support + standing - reached

    return _solve_pair(equations, theta, _jet(scene, theta)[0])
