"""How the motion of one design answers to a small error, at the tool: f'·δ with the ratio f' of the train.

What the follower answers is ``effects.answers``; of a number p of the train the tool moves by ∂f/∂p.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from camopt.effects.answers import Answers, derivatives_of, moved_by_link
from camopt.motion.driven import ratio_of
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Series, Taylor
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train


@dataclass(frozen=True)
class Responses:
    """The answers of the motion of one design at cam angles (m,) in rad: δ, δ' and δ'' of the tool, each (3, m).

    In mm or rad by mm or rad of the error; the derivatives by the cam angle in rad.
    """

    problem: Problem
    angles: FloatArray

    @cached_property
    def follower(self) -> Answers:
        """Those of the follower."""
        return Answers(self.problem.setup.mechanism, self.problem.design, self.problem.programme, self.angles)

    def to_number(self, key: str) -> FloatArray:
        """To a number that is larger than it should be, by its key: a size of the follower, a link, or an angle."""
        return self._to_link(key) if is_of_train(key) else self._tool(self.follower.to_number(key))

    def rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """To an error of a key of ``[tolerances]``, to its real and its imaginary part."""
        if key == "bore_eccentricity":
            return self.to_bore
        if key == "profile":
            return self.to_waves(waves) if waves else (self.to_profile,)
        return (self.to_number(key),)

    def to_size(self, field: str) -> FloatArray:
        """To a size of the follower, by field of ``Designs``, that is larger than it should be."""
        return self._tool(self.follower.to_size(field))

    @cached_property
    def to_profile(self) -> FloatArray:
        """To a profile that stands out along its normal everywhere, as to a roller that is larger by as much."""
        return self._tool(self.follower.to_profile)

    def to_waves(self, count: int) -> tuple[FloatArray, FloatArray]:
        """To a profile that stands out as a cosine, and as a sine, of so many waves in a turn."""
        cosine, sine = map(self._tool, self.follower.to_waves(count))
        return cosine, sine

    @cached_property
    def to_bore(self) -> tuple[FloatArray, FloatArray]:
        """To a profile whose axis is off that of the bore, in each of two directions that turn with the cam."""
        first, second = map(self._tool, self.follower.to_bore)
        return first, second

    @cached_property
    def ratio(self) -> Series | None:
        """The ratio of the train; None without one."""
        train = self.problem.setup.train
        return None if train is None else ratio_of(train, self.problem.programme, self.angles)

    def _to_link(self, key: str) -> FloatArray:
        """To a number of the train, from the series of the tool by it, whose terms are series by the cam angle."""
        problem, train = self.problem, self.problem.setup.train
        assert train is not None
        made = problem.trains({key: Taylor([problem.nominal[key], 1.0])})
        return self._terms(moved_by_link(made, train, problem.programme, self.angles))

    def _tool(self, found: Series) -> FloatArray:
        """What a series of the follower is at the tool."""
        return self._terms(found if self.ratio is None else found * self.ratio)

    def _terms(self, found: Series) -> FloatArray:
        return derivatives_of(found, self.angles.shape)
