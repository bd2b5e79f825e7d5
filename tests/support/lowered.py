"""A follower lowered on a cam of arcs and lines, to as many digits as mpmath works with: no formula of a motion.

The elements are brought where they touch by Newton's method, from where the package has them; the cam is turned,
and the follower's path is crossed with the curve that its trace point draws (a face is laid on the profile).
"""

from functools import cache
from typing import NamedTuple

import mpmath
import numpy as np
from mpmath import mp, mpc, mpf

SCAN = 40  # steps of an element in which a crossing is looked for
ROUNDED = 1e-12  # of the largest distance: doubles do not say on which side a point is
BEYOND = 1e-20  # of an element: where two meet, rounding leaves no gap


class Curve(NamedTuple):
    """A part of the profile over u from 0 to 1: points and outward normals, in the cam's own coordinates."""

    point: object
    normal: object


def curves_of(scene, parts):
    """The elements of a scene as curves; ``parts`` (the package's) only say from where to look."""
    sense = 1 if scene.cam.rotation == "ccw" else -1
    seen = [mp.conj(mpc(part.centre)) if sense > 0 else mpc(part.centre) for part in parts]
    for k, element in enumerate(scene.profile):
        if element.element == "arc" and element.x is not None:
            seen[k] = mpc(element.x, element.y)
    for k, element in enumerate(scene.profile):
        if element.element == "arc" and element.x is None:
            seen[k] = _touching_centre(scene, seen, k)
    if len(parts) == 1:
        start = mp.arg(-seen[0])
        return [_arc(mpf(scene.profile[0].radius), seen[0], start, start - sense * 2 * mp.pi)]
    normals = [_normal(scene, seen, k, sense) for k in range(len(seen))]
    found = []
    for k, element in enumerate(scene.profile):
        before, after = normals[k - 1], normals[k]
        if element.element == "line":
            found.append(
                _line(found_end(scene, seen, k - 1, before), found_end(scene, seen, k + 1, before), before)
            )
            continue
        turn = mp.arg(after / before)
        way = -sense * (1 if element.radius > 0 else -1)  # in the cam's own coordinates
        turn += 2 * mp.pi * way if turn * way < 0 else 0
        found.append(_arc(mpf(element.radius), seen[k], mp.arg(before), mp.arg(before) + turn))
    return found


def found_end(scene, centres, k, normal):
    k %= len(centres)
    return centres[k] + mpf(scene.profile[k].radius) * normal


def _touching_centre(scene, centres, k):
    """The centre at which an arc touches the arcs before and after it."""
    others = [(k - 1) % len(centres), (k + 1) % len(centres)]
    r = mpf(scene.profile[k].radius)

    def gaps(x, y):
        return [abs(mpc(x, y) - centres[j]) - abs(scene.profile[j].radius - r) for j in others]

    return mpc(*mpmath.findroot(gaps, (centres[k].real, centres[k].imag)))


def _normal(scene, centres, k, sense):
    """The outward normal where an element ends."""
    after = (k + 1) % len(centres)
    line = next((j for j in (k, after) if scene.profile[j].element == "line"), None)
    if line is None:
        r1, r2 = (mpf(scene.profile[j].radius) for j in (k, after))
        return (centres[after] - centres[k]) / (r1 - r2)
    before, after = (line - 1) % len(centres), (line + 1) % len(centres)
    r1, r2 = (mpf(scene.profile[j].radius) for j in (before, after))
    apart = centres[after] - centres[before]
    angle = mp.acos((r1 - r2) / abs(apart))  # the line is met along the turn: clockwise on a ccw cam
    return apart / abs(apart) * mp.expj(sense * angle)


def _arc(radius, centre, start, end):
    def normal(u):
        return mp.expj(start + u * (end - start))

    return Curve(lambda u: centre + radius * normal(u), normal)


def _line(start, end, normal):
    return Curve(lambda u: start + u * (end - start), lambda u: normal)


def position(scene, curves, turn):
    """Height (angle) of the follower with the cam turned by so much from where its own coordinates stand."""
    follower, turned = scene.follower, mp.expj(turn)
    body = mpf(follower.roller_radius or follower.face_radius or 0)
    found = []
    for curve in curves:
        if follower.contact == "flat":
            found.append(_highest_face_position(scene, curve, turned))
            continue

        def trace(u, curve=curve):
            return turned * (curve.point(u) + body * curve.normal(u))

        found += _crossings(scene, trace, complex(turned) * _curve_points(curve, body))
    return max(found)


@cache
def _curve_points(curve, body):
    """The curve of a trace point at the ends of all steps, in doubles."""
    return np.array(
        [complex(curve.point(u) + body * curve.normal(u)) for u in map(mpf, np.linspace(0, 1, SCAN + 1))]
    )


def _crossings(scene, trace, seen):
    """Where the trace point's curve crosses the follower's path; doubles, ``seen``, say in which steps to look."""
    follower = scene.follower
    if follower.motion == "translating":

        def off(u):
            return trace(u).real - mpf(follower.offset)

        def at(u):
            return trace(u).imag
    else:
        pivot = mpf(follower.centre_distance)

        def off(u):
            return abs(trace(u) - pivot) - mpf(follower.arm_length)

        def at(u):
            return mp.pi - mp.arg(trace(u) - pivot)

    if follower.motion == "translating":
        apart = seen.real - follower.offset
    else:
        apart = abs(seen - follower.centre_distance) - follower.arm_length
    near = abs(apart) < ROUNDED * abs(seen).max()
    for k in np.flatnonzero((apart[:-1] * apart[1:] <= 0.0) | near[:-1] | near[1:]).tolist():
        low, high = (u + (u - 0.5) * BEYOND for u in (mpf(k) / SCAN, mpf(k + 1) / SCAN))
        if off(low) * off(high) <= 0:
            u = mpmath.findroot(off, (low, high), solver="anderson", verify=False)
            if trace(u).imag > 0:
                yield at(u)


def _highest_face_position(scene, curve, turned):
    """The highest position of a face at which it touches an element."""
    follower = scene.follower

    def at(u):
        point = turned * curve.point(u)
        if follower.motion == "translating":
            return point.imag
        arm = point - mpf(follower.centre_distance)
        return mp.pi - mp.asin(mpf(follower.face_offset) / abs(arm)) - mp.arg(-arm) - mp.pi

    seen = complex(turned) * _curve_points(curve, 0)
    if follower.motion == "translating":
        values = seen.imag
    else:
        arm = seen - follower.centre_distance
        values = -np.arcsin(follower.face_offset / abs(arm)) - np.angle(-arm)
    best = int(values.argmax())
    if best in (0, SCAN):
        return at(mpf(best) / SCAN)
    return at(mpmath.findroot(lambda u: mp.diff(at, u), mpf(best) / SCAN))
