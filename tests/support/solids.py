"""Solids of STEP files read back, and what they should measure."""

from math import asin, pi, sqrt

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepAlgoAPI import BRepAlgoAPI_Section
from OCP.BRepBndLib import BRepBndLib
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_Reader
from OCP.TopoDS import TopoDS

from camopt.show.exporting import shapes
from camopt.show.exporting.step import silence_output


def solids_in(path):
    """The solids of a STEP file."""
    reader = STEPControl_Reader()
    with silence_output():
        assert reader.ReadFile(str(path)) == IFSelect_RetDone
        reader.TransferRoots()
    return shapes.subshapes(reader.OneShape(), shapes.SOLID)


def extents(solid):
    """From where to where it is along x, y and z, mm."""
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(solid, box, True, False)
    low, high = box.CornerMin(), box.CornerMax()
    return [(low.X(), high.X()), (low.Y(), high.Y()), (low.Z(), high.Z())]


def section(solid, height, count=24):
    """Points x + iy of its section at a height, edge by edge."""
    plane = gp_Pln(gp_Pnt(0.0, 0.0, height), gp_Dir(0.0, 0.0, 1.0))
    for edge in shapes.subshapes(BRepAlgoAPI_Section(solid, plane).Shape(), shapes.EDGE):
        curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
        places = map(curve.Value, np.linspace(curve.FirstParameter(), curve.LastParameter(), count).tolist())
        yield np.array([complex(place.X(), place.Y()) for place in places])


def enclosed_area(points):
    """The area inside of points of a closed line, mm² (Green's theorem)."""
    return abs((points.conjugate() * np.roll(points, -1)).imag.sum()) / 2


def hole(part):
    """The area of bore and keyway, mm²: the keyway beyond the circle of the bore."""
    r, w = part["bore"] / 2, part.get("keyway_width", 0.0)
    under = w / 2 * sqrt(r * r - w * w / 4) + r * r * asin(w / 2 / r)  # ∫√(r² − x²) dx from −w/2 to w/2
    return pi * r * r + w * (r + part.get("keyway_depth", 0.0)) - under
