"""The standard of a drawing: ISO in mm, or ASME in inches.

A standard says which papers, title block, projection and texts of sizes a sheet has.

A sheet is drawn by the standard of the shown units; ``part.standard`` sets these for the drawing.

Sources: ASME Y14.1-2012 (paper, title block), Y14.2-2014 (lines, letters), Y14.3-2012 (third angle, sections),
Y14.5-2018 (decimal inches, limits, basic dimensions), Y14.36M-1996 (surface texture).
"""

from functools import partial
from math import ceil, floor

from camopt.core.quantities.unit_systems import INCH, INCH_MM, MM, shown_system
from camopt.core.storage.version import VERSION
from camopt.scene.iso286 import Deviations
from camopt.scene.part import Part
from camopt.show.sheet.languages import LANGUAGES
from camopt.show.sheet.marks import decimal_text
from camopt.show.sheet.paper import (
    A2,
    A3,
    A4,
    ANSI_PAPERS,
    BLOCK_HEIGHT,
    BLOCK_ROW,
    BLOCK_WIDTH,
    LINES_FIELD,
    PROJECTION_FIELD,
    Field,
    Paper,
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

    def title_fields(self, part: Part, title: str, scale: str, paper: str, sheet: str) -> list[Field]:
        """The fields of the title block, from its lower left corner."""
        hardness = ", ".join(filter(None, (part.hardness, part.case_depth and f"CHD {part.case_depth}")))
        return [
            Field(0, 27, 75, BLOCK_ROW, "Material", part.material or ""),
            Field(75, 27, 55, BLOCK_ROW, "Hardness", hardness),
            Field(130, 27, 22, BLOCK_ROW, "Scale", scale),
            Field(152, 27, 28, BLOCK_ROW, PROJECTION_FIELD),
            Field(0, 18, 45, BLOCK_ROW, "Created by", part.designer or ""),
            Field(45, 18, 45, BLOCK_ROW, "Approved by", part.approved_by or ""),
            Field(90, 18, 40, BLOCK_ROW, "Document type", LANGUAGES[part.language]("Part drawing")),
            Field(130, 18, 32, BLOCK_ROW, "Source", f"camopt {VERSION}"),
            Field(162, 18, 18, BLOCK_ROW, "Format", paper),
            Field(0, 0, 45, 2 * BLOCK_ROW, "Legal owner", part.legal_owner or ""),
            Field(45, 0, 85, 2 * BLOCK_ROW, "Title", title),
            Field(130, 9, 50, BLOCK_ROW, "Identification number", part.number or ""),
            Field(130, 0, 10, BLOCK_ROW, "Rev.", part.revision or ""),
            Field(140, 0, 20, BLOCK_ROW, "Date of issue", part.date_of_issue or ""),
            Field(160, 0, 8, BLOCK_ROW, "Lang.", part.language),
            Field(168, 0, 12, BLOCK_ROW, "Sheet", sheet),
        ]


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

    def title_fields(self, part: Part, title: str, scale: str, paper: str, sheet: str) -> list[Field]:
        depth = part.case_depth and f"CASE {part.case_depth}{'' if part.case_depth[-1].isalpha() else ' mm'}"
        tolerances = part.general_tolerances or "\n.XX ±.01\n.XXX ±.005\n.XXXX ±.0010\nANGLES ±0.5°"
        lines = (
            f"UNLESS OTHERWISE SPECIFIED:\nDIMENSIONS ARE IN INCHES\nTOLERANCES: {tolerances}",
            f"SURFACES {self.roughness_text(part.other_roughness or 3.2)} µin Ra",
            *(() if part.edges else ("BREAK SHARP EDGES",)),
            "INTERPRET PER ASME Y14.5-2018\nDO NOT SCALE DRAWING",
        )
        return [
            Field(0, 10, 56, 40.8, LINES_FIELD, "\n".join(lines)),
            Field(0, 0, 56, 10, PROJECTION_FIELD, "THIRD ANGLE\nPROJECTION"),
            Field(56, 40.8, 46, 10, "DRAWN", " ".join(filter(None, (part.designer, part.date_of_issue)))),
            Field(56, 30.6, 46, 10.2, "CHECKED"),
            Field(56, 20.4, 46, 10.2, "APPROVED", part.approved_by or ""),
            Field(56, 10.2, 46, 10.2, "MATERIAL", part.material or ""),
            Field(56, 0, 46, 10.2, "HARDNESS / FINISH", "; ".join(filter(None, (part.hardness, depth)))),
            Field(102, 38.1, 84, 12.7, "COMPANY", part.legal_owner or ""),
            Field(102, 22.4, 84, 15.7, "TITLE", title),
            Field(102, 9.7, 12, 12.7, "SIZE", paper),
            Field(114, 9.7, 60, 12.7, "DWG NO.", part.number or ""),
            Field(174, 9.7, 12, 12.7, "REV", part.revision or ""),
            Field(102, 0, 26, 9.7, "SCALE", scale),
            Field(128, 0, 34, 9.7, "SOURCE", f"camopt {VERSION}"),
            Field(162, 0, 24, 9.7, "SHEET", sheet.replace("/", " OF ")),
        ]


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
