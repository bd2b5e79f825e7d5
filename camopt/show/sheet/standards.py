"""The standard of a drawing: ISO in mm, or ASME in inches.

A standard says which papers, title block, projection and texts of sizes a sheet has.

A sheet is drawn by the standard of the shown units; ``part.standard`` sets these for the drawing.

Sources: ASME Y14.1-2012 (paper, title block), Y14.2-2014 (lines, letters), Y14.3-2012 (third angle, sections),
Y14.5-2018 (decimal inches, limits, basic dimensions), Y14.36M-1996 (surface texture).
"""

from functools import partial
from math import ceil, floor

from camopt.core.quantities.unit_systems import INCH, INCH_MM, MM, shown_system
from camopt.scene.iso286 import Deviations
from camopt.scene.part import Part
from camopt.show.sheet.marks import Marks, decimal_text
from camopt.show.sheet.paper import (
    A2,
    A3,
    A4,
    ANSI_PAPERS,
    BLOCK_HEIGHT,
    BLOCK_WIDTH,
    Paper,
    asme_fields,
    title_block,
)

SYSTEM_OF_STANDARD, ROUNDING = {"iso": MM, "asme": INCH}, 1e-6  # of a last digit, against rounding errors


class IsoStandard:
    """A drawing by ISO in mm: first angle, A4 to A2, fits by their names."""

    papers: tuple[Paper, ...] = (A4, A3, A2)
    scale_series: tuple[float, ...] = (1.0, 2.0, 5.0)
    block_size = complex(BLOCK_WIDTH, BLOCK_HEIGHT)
    # +1: the section beside the front view is seen from the left, −1: from the right; lengths of texts over ISO's
    section_side, text_share = 1.0, 1.0
    section_name = "A–A"
    # Whether values between the rows of the table can be interpolated, lengths keep their trailing zeros, unit,
    # projection and general tolerances are in the title block, and the language is always English.
    has_dense_table = has_fixed_decimals = has_tolerance_block = is_english = False

    def length_text(self, length: float, digits: int = 3, is_general: bool = False) -> str:
        """A length given in mm; general tolerances apply to it, or not."""
        return decimal_text(length, digits)

    def toleranced_text(self, size: float, tolerance: str, deviations: Deviations | None) -> str:
        """A size [mm] with the text of its tolerance, or with its limits."""
        return f"{self.length_text(size)} {tolerance}"

    def roughness_text(self, roughness: float) -> str:
        """A roughness Ra, given in µm."""
        return f"Ra {roughness:.3g}"

    def title_block(self, part: Part, title: str, scale: str, paper: str, sheet: str) -> Marks:
        """The title block from its lower left corner."""
        return title_block(part, title, scale, paper, sheet)


class AsmeStandard(IsoStandard):
    """A drawing by ASME Y14 in inches: third angle, sizes A to D, limits in place of fits, basic radii."""

    papers = ANSI_PAPERS
    scale_series = (1.0, 2.0, 4.0)
    block_size = complex(186.0, 50.8)
    section_side, text_share = -1.0, 1.25
    section_name = "SECTION A-A"
    has_dense_table = has_fixed_decimals = has_tolerance_block = is_english = True

    def length_text(self, length: float, digits: int = 3, is_general: bool = False) -> str:
        return inch_text(length / INCH_MM, 3 if is_general else 4)

    def toleranced_text(self, size: float, tolerance: str, deviations: Deviations | None) -> str:
        if deviations is None:
            return super().toleranced_text(size, tolerance, deviations)
        low, high = ((size + deviation) / INCH_MM for deviation in deviations)
        decimals = 4 if high - low >= 4e-4 else 5
        digits = 10.0**decimals  # limits are rounded inwards
        ends = ceil(low * digits - ROUNDING) / digits, floor(high * digits + ROUNDING) / digits
        return "-".join(inch_text(end, decimals) for end in ends)

    def roughness_text(self, roughness: float) -> str:
        return MICROINCHES.get(roughness, f"{roughness / INCH_MM * 1e3:.3g}")

    def title_block(self, part: Part, title: str, scale: str, paper: str, sheet: str) -> Marks:
        surfaces = self.roughness_text(part.other_roughness or 3.2)
        fields = asme_fields(part, title, scale, paper, sheet, surfaces)
        return title_block(part.model_copy(update={"language": "en"}), title, scale, paper, sheet, fields)


# preferred roughnesses [µin] by those in µm
MICROINCHES = {0.05: "2", 0.1: "4", 0.2: "8", 0.4: "16", 0.8: "32", 1.6: "63", 3.2: "125", 6.3: "250", 12.5: "500"}


def inch_text(inches: float, decimals: int) -> str:
    """A length in inches with fixed decimals, and no zero before the point."""
    return f"{'−' if round(inches, decimals) < 0.0 else ''}{f'{abs(inches):.{decimals}f}'.lstrip('0')}"


STANDARDS: dict[str, IsoStandard] = {MM: IsoStandard(), INCH: AsmeStandard()}


def sheet_standard() -> IsoStandard:
    """The standard by which sheets are drawn now."""
    return STANDARDS[shown_system()]


def length_text(length: float, digits: int = 3, is_general: bool = False) -> str:
    """A length given in mm, as a dimension of the drawing; general tolerances apply to it, or not."""
    return sheet_standard().length_text(length, digits, is_general)


size_text = partial(length_text, is_general=True)
