"""The smallest cam of each known law, to compare with free laws, and the best known law within the limits."""

from dataclasses import dataclass

from camopt.scene.scene import Scene
from camopt.solve.synthesis.cams import (
    has_laws_of_scene,
    known_cam_with_objective_terms,
    smallest_designs_by_known_law,
)
from camopt.solve.synthesis.law_infeasibility import broken_limit_keys_in_words
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.result_sentences import OWN_MOVES
from camopt.solve.tables.designs import Design


@dataclass(frozen=True)
class KnownLawCams:
    """The known laws of a scene, each on the smallest cam that its [limits] allow.

    ``rows`` are the designs by law. Each has ``within`` (whether the motion meets all limits of the free laws) and
    ``objective`` (in its unit). The scene's own laws have no row if no cam with them is feasible.
    """

    scene: Scene
    rows: dict[str, Design]
    broken_limits: dict[str, str]
    """The limits that each law breaks, for laws that are not ``within``."""

    @property
    def own_law(self) -> str | None:
        """Key of the scene's own laws; None if no cam with them is feasible."""
        return next((law for law, row in self.rows.items() if has_laws_of_scene(row, self.scene)), None)

    @property
    def best(self) -> str | None:
        """Key of the laws with the least objective within all limits; None if no known law meets them."""
        within = {law: row["objective"] for law, row in self.rows.items() if row["within"]}
        return min(within, key=lambda law: within[law], default=None)


def build_known_law_cams(scene: Scene) -> KnownLawCams:
    """The cams of the known laws of a scene that ``synthesise`` accepts."""
    problem = build_synthesis_problem(scene)
    rows = {
        law or OWN_MOVES: known_cam_with_objective_terms(problem, row)
        for law, row in smallest_designs_by_known_law(scene).items()
    }
    for row in rows.values():
        row["objective"] = sum(weight * row[name] for name, weight in problem.objective.items())
    return KnownLawCams(
        scene,
        rows,
        {law: broken_limit_keys_in_words(scene, problem, row) for law, row in rows.items() if not row["within"]},
    )
