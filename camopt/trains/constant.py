"""A link of constant ratio."""

from dataclasses import dataclass

from camopt.numerics.taylor import Series
from camopt.trains.link import FREE, NO_COUPLERS, DeadPoint, one_like


@dataclass(frozen=True)
class Constant:
    """Output = factor·input: gears, racks, belts, levers, wedges."""

    factor: float
    turns: tuple[bool, bool]
    couplers = NO_COUPLERS

    @property
    def ends(self) -> tuple[DeadPoint, DeadPoint]:
        return FREE

    def forward(self, given: Series) -> Series:
        return given * self.factor

    def backward(self, asked: Series) -> Series:
        return asked / self.factor

    def ratio(self, given: Series) -> Series:
        return one_like(given) * self.factor
