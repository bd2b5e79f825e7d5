"""Texts of a drawing in English (as in the code) and German."""

import re
from collections.abc import Callable

GERMAN = {
    # title block
    "Material": "Werkstoff",
    "Hardness": "Härte",
    "Scale": "Maßstab",
    "Created by": "Erstellt durch",
    "Approved by": "Genehmigt von",
    "Document type": "Dokumentenart",
    "Part drawing": "Teilezeichnung",
    "Source": "Quelle",
    "Format": "Format",
    "Legal owner": "Eigentümer",
    "Title": "Titel",
    "Identification number": "Sachnummer",
    "Rev.": "Änd.",
    "Date of issue": "Ausgabedatum",
    "Lang.": "Spr.",
    "Sheet": "Blatt",
    # what the follower does
    "rise": "Anstieg",
    "dwell": "Rast",
    "return": "Rückgang",
    "move": "Bewegung",
    "constant velocity": "gleichförmig",
    # views
    "timing mark": "Einstellmarke",
    "rotation": "Drehsinn",
    "{} rev/min": "{} min⁻¹",
    "the surface moves": "die Oberfläche bewegt sich",
    # table
    "profile": "Kontur",
    "centre": "Mitte",
    "knife edge": "Schneide",
    "roller centre": "Rollenmitte",
    "face centre": "Flächenmitte",
    # notes
    "Breaks limits of its design: {}.": "Verletzt Grenzen der Auslegung: {}.",
    "Not proved to meet the limits of its design.": "Die Grenzen der Auslegung sind nicht nachgewiesen.",
    "Dimensions in mm. Projection method 1.": "Maße in mm. Projektionsmethode 1.",
    "General tolerances {}.": "Allgemeintoleranzen {}.",
    "Edges ISO 13715: outer {}, inner {}.": "Kanten ISO 13715: außen {}, innen {}.",
    "Other surfaces Ra {}.": "Übrige Oberflächen Ra {}.",
    "For {}.": "Für {}.",
    "Disc {}: for {}.": "Scheibe {}: für {}.",
    "a yoke {}": "einen Rahmen {}",
    "with two rollers Ø{}": "mit zwei Rollen Ø{}",
    "with two flat faces": "mit zwei ebenen Flächen",
    "a translating follower {}": "einen geradgeführten Stößel {}",
    "an oscillating follower {}": "einen Schwinghebel {}",
    "with a roller Ø{}": "mit Rolle Ø{}",
    "with a spherical face R{}": "mit Kugelfläche R{}",
    "with a flat face": "mit ebener Fläche",
    "with a knife edge": "mit Schneide",
    "arm {}": "Arm {}",
    "distance of the pivot from the cam's axis {}": "Abstand des Drehpunkts von der Kurvenachse {}",
    "distance of the face from the pivot {}": "Abstand der Fläche vom Drehpunkt {}",
    "its axis offset by {} to the right": "Achse um {} nach rechts versetzt",
    "its axis offset by {} to the left": "Achse um {} nach links versetzt",
    " at {} rev/min": " mit {} min⁻¹",
    "The groove is developed at the mean radius, as seen from outside: the cam turns clockwise, as seen from "
    "above; the surface moves as the arrow shows{}.": (
        "Nut am mittleren Radius abgewickelt, von außen gesehen: Die Kurve dreht im Uhrzeigersinn, von oben "
        "gesehen; die Oberfläche bewegt sich in Pfeilrichtung{}."
    ),
    "The groove is developed at the mean radius, as seen from inside: the cam turns counter-clockwise, as seen "
    "from above; the surface moves as the arrow shows{}.": (
        "Nut am mittleren Radius abgewickelt, von innen gesehen: Die Kurve dreht gegen den Uhrzeigersinn, von oben "
        "gesehen; die Oberfläche bewegt sich in Pfeilrichtung{}."
    ),
    "The rib is developed at the mean radius, as seen from outside: the cam turns clockwise, as seen from "
    "above; the surface moves as the arrow shows{}.": (
        "Rippe am mittleren Radius abgewickelt, von außen gesehen: Die Kurve dreht im Uhrzeigersinn, von oben "
        "gesehen; die Oberfläche bewegt sich in Pfeilrichtung{}."
    ),
    "The rib is developed at the mean radius, as seen from inside: the cam turns counter-clockwise, as seen "
    "from above; the surface moves as the arrow shows{}.": (
        "Rippe am mittleren Radius abgewickelt, von innen gesehen: Die Kurve dreht gegen den Uhrzeigersinn, von "
        "oben gesehen; die Oberfläche bewegt sich in Pfeilrichtung{}."
    ),
    "Turns clockwise{} in the front view, which shows cam angle 0.": (
        "Dreht im Uhrzeigersinn{}, gesehen in der Vorderansicht, die bei Drehwinkel 0 steht."
    ),
    "Turns counter-clockwise{} in the front view, which shows cam angle 0.": (
        "Dreht gegen den Uhrzeigersinn{}, gesehen in der Vorderansicht, die bei Drehwinkel 0 steht."
    ),
    "Angles round the cam start at the direction of the centre of the face at cam angle 0.": (
        "Winkel um die Kurve: ab 0°, der Richtung zur Mitte der Fläche bei Drehwinkel 0."
    ),
    "Angles round the cam start at the direction of the roller's centre at cam angle 0.": (
        "Winkel um die Kurve: ab 0°, der Richtung zur Rollenmitte bei Drehwinkel 0."
    ),
    "Angles round the cam start at the direction of the point of contact at cam angle 0.": (
        "Winkel um die Kurve: ab 0°, der Richtung zum Berührpunkt bei Drehwinkel 0."
    ),
    " Bent lines lead to the point of contact on the profile.": (
        " Geknickte Linien führen zum Berührpunkt auf der Kontur."
    ),
    "The keyway is at cam angle {}°.": "Die Passfedernut liegt bei Drehwinkel {}°.",
    "The keyway is at cam angle {}°, where the section is.": (
        "Die Passfedernut liegt bei Drehwinkel {}°, im Schnitt."
    ),
    "Middle of the keyway at φ {}°.": "Mitte der Passfedernut bei φ {}°.",
    "Bore and keyway: {}.": "Bohrung mit Passfedernut: {}.",
    "Lift {}": "Hub {}",
    "s: lift of the follower, {}.": "s: Hub des Eingriffsglieds, {}.",
    "Tool at the end of the train: lift {}": "Werkzeug am Ende des Getriebezugs: Hub {}",
    "θ {}° to {}° at constant velocity {}{}": "θ {}° bis {}° gleichförmig {}{}",
    "Table: cam angle θ, lift s; {} x round the mean radius, y along the axis.": (
        "Tabelle: Drehwinkel θ, Hub s; {} x um den mittleren Radius, y längs der Achse."
    ),
    "Table: cam angle θ; {} x round the mean radius, y along the axis is the lift s.": (
        "Tabelle: Drehwinkel θ; {} x um den mittleren Radius, y längs der Achse: ihr Hub s."
    ),
    "Edges of the groove chamfered {} × 45°.": "Kanten der Nut mit {} × 45° gebrochen.",
    "Table: cam angle θ, lift s; polar angle φ from the timing mark against the rotation, radius r.": (
        "Tabelle: Drehwinkel θ, Hub s; Polarwinkel φ ab der Einstellmarke gegen den Drehsinn, Radius r."
    ),
    " Profile: contact; centre: of the roller, or of a cutter R{}.": (
        " Kontur: Berührpunkt; Mitte: der Rolle oder eines Fräsers R{}."
    ),
    " Centre: of the roller, or of a cutter as wide as the groove.": (
        " Mitte: der Rolle oder eines Fräsers von der Breite der Nut."
    ),
    "Clearance of the roller Ø{} in its groove{}{}.": "Spiel der Rolle Ø{} in ihrer Nut{}{}.",
    ", from {} to {}": ", von {} bis {}",
    "Clearance of the rib between its rollers {}.": "Spiel der Rippe zwischen ihren Rollen {}.",
    "distance of the rollers {}": "im Abstand {}",
    "roller {}": "Rolle {}",
    "rib at least {} thick": "Rippe mindestens {} dick",
    " Centres of rollers 1, outside of the rib, and 2, within it.": (
        " Mitten der Rollen 1, außerhalb der Rippe, und 2, innerhalb."
    ),
    "Table: cam angle θ, lift s; centres of rollers 1, beyond the rib, and 2: x round the mean radius, "
    "y along the axis.": (
        "Tabelle: Drehwinkel θ, Hub s; Mitten der Rollen 1, jenseits der Rippe, und 2: x um den mittleren Radius, "
        "y längs der Achse."
    ),
    # two contacts
    "Inspect the rib between both rollers, over a turn: distance of their centres {}.": (
        "Rippe zwischen beiden Rollen prüfen, über eine Umdrehung: Abstand ihrer Mitten {}."
    ),
    "Inspect the rib between both rollers, over a turn: angle between the arms {}.": (
        "Rippe zwischen beiden Rollen prüfen, über eine Umdrehung: Winkel zwischen den Armen {}."
    ),
    "Conjugate pair: disc {} in full lines, disc {} dashed. Both tables are from the same timing mark{}.": (
        "Doppelkurve: Scheibe {} in Volllinien, Scheibe {} gestrichelt. Beide Tabellen ab derselben "
        "Einstellmarke{}."
    ),
    "{}, disc {}": "{}, Scheibe {}",
    ", on disc 1": ", auf Scheibe 1",
    ", which each disc has": ", die jede Scheibe hat",
    "Angle between both arms {}": "Winkel zwischen beiden Armen {}",
    "Distance of both flat faces {}": "Abstand beider ebenen Flächen {}",
    "Distance of the centres of both rollers {}": "Abstand der Mitten beider Rollen {}",
    "{}.": "{}.",
    "{}, made {} for an interference of {}.": "{}, gefertigt {} für ein Übermaß von {}.",
    "Inspect the breadth between two parallel faces, in every direction: {}.": (
        "Breite zwischen zwei parallelen Flächen prüfen, in jeder Richtung: {}."
    ),
    "Inspect the disc between two rollers on opposite sides, over a turn: distance of their centres {}.": (
        "Scheibe zwischen zwei Rollen auf beiden Seiten prüfen, über eine Umdrehung: Abstand ihrer Mitten {}."
    ),
    "Inspect both discs together, with both rollers on them, over a turn: angle between the arms {}.": (
        "Beide Scheiben zusammen prüfen, mit beiden Rollen, über eine Umdrehung: Winkel zwischen den Armen {}."
    ),
    "Inspect both discs together, with both rollers on them, over a turn: distance of their centres {}.": (
        "Beide Scheiben zusammen prüfen, mit beiden Rollen, über eine Umdrehung: Abstand ihrer Mitten {}."
    ),
    "Within the tolerance of the profile the interference may be lost: clearance up to {}.": (
        "Innerhalb der Toleranz der Kontur kann das Übermaß verloren gehen: Spiel bis {}."
    ),
    " Profile: contact; centre: of the spherical face R{}.": " Kontur: Berührpunkt; Mitte: der Kugelfläche R{}.",
    "largest pressure angle {}°": "größter Pressungswinkel {}°",
    "at the bottom of the groove {}°": "am Grund der Nut {}°",
    "at the foot of the rib {}°": "am Fuß der Rippe {}°",
    "smallest convex radius of the profile {}": "kleinster erhabener Radius {}",
    "cutter or wheel in hollow flanks at most R{}": "Fräser in hohlen Flanken bis R{}",
    "cutter at most Ø{}": "Fräser bis Ø{}",
    "mass {}": "Masse {}",
}
"""German texts by English text; {} is the place of a value. Laws, names and materials are not translated."""

LANGUAGES: dict[str, Callable[[str], str]] = {"en": str, "de": GERMAN.__getitem__}
"""A function that translates English texts, by language."""

DECIMAL_POINT = re.compile(r"(?<=\d)\.(?=\d)")


def with_decimal_sign(text: str, language: str) -> str:
    """A text of the drawing with the decimal sign of its language."""
    return text if language == "en" else DECIMAL_POINT.sub(",", text)
