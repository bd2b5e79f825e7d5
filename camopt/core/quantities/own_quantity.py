"""Quantities that a scene defines: numbers computed from other quantities of each design."""

from dataclasses import dataclass, field

from camopt.core.quantities.expression import ExpressionNode
from camopt.core.quantities.function import FunctionCall
from camopt.core.quantities.quantity import AT_MOST, Quantity

OWN_EFFECT = "quantities"
"""Effect of the quantities that a scene defines, and the name of their table."""


@dataclass(frozen=True)
class OwnQuantity(Quantity):
    """A quantity that a scene defines by an expression or function of others. Its limit is an upper bound."""

    tree: ExpressionNode | FunctionCall = field(default_factory=lambda: ExpressionNode(""), repr=False)

    @property
    def quantities_read(self) -> tuple[str, ...]:
        """Names of the quantities from which it is computed."""
        return self.tree.names

    @property
    def function_call(self) -> FunctionCall | None:
        """The call of its Python function; None for an expression."""
        return self.tree if isinstance(self.tree, FunctionCall) else None

    @property
    def relation_to_limit(self) -> str:
        """Relation to its limit: always ≤."""
        return AT_MOST
