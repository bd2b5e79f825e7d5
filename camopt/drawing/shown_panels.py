"""All diagrams of a design, in the units in which results are shown."""

from camopt.drawing.dynamics import dynamics_panels
from camopt.drawing.loads import load_panels
from camopt.drawing.panels import Panel, panels
from camopt.drawing.picture import Picture


def shown_panels(picture: Picture) -> list[Panel]:
    """Motion, pressure angle, curvature, and the loads that were computed."""
    return [each.as_shown() for each in (*panels(picture), *dynamics_panels(picture), *load_panels(picture))]
