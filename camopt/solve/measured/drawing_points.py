"""Points of the profile that a DXF file draws, on its curves and not on chords between them."""

from dataclasses import replace
from os import PathLike, fsdecode
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np

from camopt.core.mistakes import join_words
from camopt.core.numerics import ComplexArray
from camopt.core.quantities.unit_systems import shown_system
from camopt.scene.dxf import DrawnOutline, read_dxf_outlines
from camopt.solve.measured.columns import MM_PER_UNIT, XY_TABLE, TableReadingOptions
from camopt.solve.measured.number_table import TABLE_ROWS, NumberTable

DXF_SUFFIX = ".dxf"
WIDEST_STEP = np.radians(0.5)  # between points, as seen from the axis
LEAST_RISE = 1e-3  # mm: a curve that is nearer to a circle about the axis is none of a cam


def is_drawing(points: Any) -> "TypeGuard[str | PathLike[str]]":
    """Whether points are those of a DXF file."""
    return isinstance(points, (str, PathLike)) and Path(fsdecode(points)).suffix.lower() == DXF_SUFFIX


def read_drawing(path: Path, reading_options: TableReadingOptions) -> tuple[NumberTable, TableReadingOptions]:
    """Points x, y [mm] of the profile that a DXF file draws, and columns that say so.

    Raises
    ------
    ValueError
        If the file cannot be read, or if it is not clear which of its curves is the profile.
    """
    if reading_options.kind is not XY_TABLE:
        raise ValueError("draws a profile, with points x and y")
    outlines, unit_mm = read_dxf_outlines(path, reading_options.layer, with_splines=True)
    size = (
        MM_PER_UNIT[reading_options.lift_unit]
        if reading_options.lift_unit
        else unit_mm or MM_PER_UNIT[shown_system()]
    )
    profiles = [each for each in outlines if _is_profile(each.outline, LEAST_RISE / size)]
    if not profiles:
        raise ValueError("has no closed curve round the axis at x = 0, y = 0 other than circles about it")
    if len(profiles) > 1:
        radii = [float(np.abs(points_on_outline(each.outline)).max()) * size for each in profiles]
        pairs = zip(profiles, radii, strict=True)
        curves = [f"a curve on the layer {each.layer!r} (largest radius {r:.4g} mm)" for each, r in pairs]
        remedy = "give the layer of the profile, or keep one of them"
        raise ValueError(f"has {join_words(curves)} about the axis; {remedy}")
    points = points_on_outline(profiles[0].outline) * size
    if points.size > TABLE_ROWS:
        raise ValueError(f"draws the profile with {points.size:,} points; at most {TABLE_ROWS:,} are allowed")
    table = NumberTable(np.column_stack([points.real, points.imag]), np.arange(1, points.size + 1), ("", ""))
    return table, replace(reading_options, chosen=None, lift_unit="mm")


def points_on_outline(outline: DrawnOutline) -> ComplexArray:
    """Vertices of an outline, and points on its arcs and on lines beside arcs, at most 0.5 deg apart.

    Lines between lines are chords of a curve: no point between their ends is on it.
    """
    is_arc = outline.bulges != 0.0
    is_curve = is_arc | np.roll(is_arc, 1) | np.roll(is_arc, -1)
    parts = []
    for start, chord, bulge, curved in zip(outline.vertices, outline.chords, outline.bulges, is_curve, strict=True):
        count = max(int(np.ceil(abs(np.angle((start + chord) / start)) / WIDEST_STEP)), 1) if curved else 1
        share = np.arange(count) / count
        if bulge:  # equal angles of an arc about its centre
            to_centre = chord * (0.5 + 0.25j * (1.0 / bulge - bulge))
            parts.append(start + to_centre * (1.0 - np.exp(4j * np.arctan(bulge) * share)))
        else:
            parts.append(start + chord * share)
    return np.concatenate(parts)


def _is_profile(outline: DrawnOutline, least_radius_range: float) -> bool:
    """Whether an outline goes round the axis, and is no circle about it."""
    points = np.column_stack([outline.vertices, outline.arc_middles]).ravel()
    distances = np.abs(points)
    if not distances.min() > 0.0:
        return False
    turn = np.angle(np.roll(points, -1) / points).sum()
    return bool(abs(turn) > np.pi and np.ptp(distances) > least_radius_range)
