"""The title block by ISO 7200, 180 mm wide, in the lower right corner. Fields that are not given stay empty."""

from typing import NamedTuple

from camopt.scene.part import Part
from camopt.sheet import symbols
from camopt.sheet.marks import BORDER, LARGE, MEDIUM, SMALL, THIN, Marks, Words, fitted_words, rectangle
from camopt.sheet.words import LANGUAGES
from camopt.storage.version import VERSION

BLOCK_WIDTH, BLOCK_HEIGHT, ROW = 180.0, 36.0, 9.0  # mm
FIELD_PAD = 0.9  # mm: from the edges of a field
LEADING = 1.4  # heights of letters from one line to the next
TITLE_HEIGHT = 5.0  # mm: height of the letters of a short title
FIGURE = "projection"


class Field(NamedTuple):
    """A field from its lower left corner, in mm, with its name and value."""

    x: float
    y: float
    width: float
    height: float
    name: str
    value: str = ""


def fields(part: Part, title: str, scale: str, paper: str, sheet: str) -> list[Field]:
    """What is written where."""
    hardness = ", ".join(filter(None, (part.hardness, part.case_depth and f"CHD {part.case_depth}")))
    return [
        Field(0, 27, 75, ROW, "Material", part.material or ""),
        Field(75, 27, 55, ROW, "Hardness", hardness),
        Field(130, 27, 22, ROW, "Scale", scale),
        Field(152, 27, 28, ROW, FIGURE),
        Field(0, 18, 45, ROW, "Created by", part.designer or ""),
        Field(45, 18, 45, ROW, "Approved by", part.approved_by or ""),
        Field(90, 18, 40, ROW, "Document type", LANGUAGES[part.language]("Part drawing")),
        Field(130, 18, 32, ROW, "Source", f"camopt {VERSION}"),
        Field(162, 18, 18, ROW, "Format", paper),
        Field(0, 0, 45, 2 * ROW, "Legal owner", part.legal_owner or ""),
        Field(45, 0, 85, 2 * ROW, "Title", title),
        Field(130, 9, 50, ROW, "Identification number", part.number or ""),
        Field(130, 0, 10, ROW, "Rev.", part.revision or ""),
        Field(140, 0, 20, ROW, "Date of issue", part.date_of_issue or ""),
        Field(160, 0, 8, ROW, "Lang.", part.language),
        Field(168, 0, 12, ROW, "Sheet", sheet),
    ]


def title_block(part: Part, title: str, scale: str, paper: str, sheet: str) -> Marks:
    """The title block from its lower left corner."""
    say = LANGUAGES[part.language]
    marks: Marks = [rectangle(0j, complex(BLOCK_WIDTH, BLOCK_HEIGHT), BORDER)]
    for field in fields(part, title, scale, paper, sheet):
        marks.append(
            rectangle(complex(field.x, field.y), complex(field.x + field.width, field.y + field.height), THIN)
        )
        if field.name == FIGURE:
            marks += symbols.projection(complex(field.x + field.width / 2, field.y + field.height / 2))
            continue
        top = field.y + field.height - FIELD_PAD - SMALL
        marks.append(Words(complex(field.x + FIELD_PAD, top), say(field.name), SMALL))
        marks += _value(field, top - FIELD_PAD)
    return marks


def _value(field: Field, top: float) -> Marks:
    """A value below the name of its field, in the largest letters that fit."""
    if not field.value:
        return []
    tall = field.height > ROW
    heights = (TITLE_HEIGHT, LARGE, MEDIUM, SMALL) if tall else (LARGE, MEDIUM, SMALL)
    room = field.width - 2 * FIELD_PAD
    texts, height = fitted_words(field.value, room, 1, heights[:-2] if tall else heights[:-1])
    if texts[0] != " ".join(field.value.split()):
        texts, height = fitted_words(field.value, room, 2, (MEDIUM, SMALL) if tall else (SMALL,))
    step = height * LEADING
    foot = field.y + FIELD_PAD + (len(texts) - 1) * step
    foot += max(0.0, (top - height - foot) / 2)
    return [Words(complex(field.x + FIELD_PAD, foot - k * step), text, height) for k, text in enumerate(texts)]
