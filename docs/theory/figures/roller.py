"""The cam of several figures: a roller follower that rises and returns by 25 mm."""

import camopt
from camopt.scene.problem.problem import resolve_design

SCENE = camopt.Scene.from_dict(
    {
        "cam": {"form": "disc", "base_radius": 40},
        "follower": {"motion": "translating", "contact": "roller", "roller_radius": 8},
        "motion": [
            {"segment": "rise", "angle": 100, "lift": 25, "law": "cycloidal"},
            {"segment": "return", "angle": 120, "lift": 25, "law": "modified-sine"},
            {"segment": "dwell", "angle": 140},
        ],
    }
)
PROGRAMME = resolve_design(SCENE).programme
