"""Quantities of a scene's own: numbers that follow from the quantities of each design."""

from dataclasses import dataclass, field

from camopt.core.quantities.expression import ExpressionNode
from camopt.core.quantities.function import FunctionCall
from camopt.core.quantities.quantity import AT_MOST, Quantity

OWN_EFFECT = "quantities"
"""What quantities of a scene's own have as their effect, and the table that gives them."""


@dataclass(frozen=True)
class OwnQuantity(Quantity):
    """A quantity that a scene defines by an expression or a function of others; a bound on it is one from above."""

    tree: ExpressionNode | FunctionCall = field(default_factory=lambda: ExpressionNode(""), repr=False)

    @property
    def reads(self) -> tuple[str, ...]:
        """The quantities from which it follows."""
        return self.tree.names

    @property
    def call(self) -> FunctionCall | None:
        """The call of a Python function that it is; None of an expression."""
        return self.tree if isinstance(self.tree, FunctionCall) else None

    @property
    def relation(self) -> str:
        """The relation to its bound."""
        return AT_MOST


def own_quantity(name: str, unit: str, sentence: str, tree: ExpressionNode | FunctionCall) -> OwnQuantity:
    """A quantity of a scene's own."""
    return OwnQuantity(name, "", unit, OWN_EFFECT, sentence, tree=tree)
