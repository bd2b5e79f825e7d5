"""Machines and scenes for the tests of machines."""

KNIFE = {
    "cam": {"form": "disc", "base_radius": 40, "rpm": 90.0},
    "follower": {"motion": "translating", "contact": "knife"},
    "motion": [
        {"segment": "rise", "angle": 120, "lift": 20, "law": "cycloidal"},
        {"segment": "return", "angle": 120, "lift": 20, "law": "cycloidal"},
        {"segment": "dwell", "angle": 120},
    ],
}
"""The least scene of a station: it has a speed and no forces."""
