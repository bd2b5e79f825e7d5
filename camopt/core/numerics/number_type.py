"""Number types with their own rules for Python's operators and numpy's functions, also in kernels."""

import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from camopt.core.kernels.marks import chosen_by_type

OWN, OTHER = True, False
OWN_PAIR = (OWN, OWN)
OperationRules = Mapping[Any, Mapping[tuple[bool, ...], Callable[..., Any]]]
"""Rules of each operation, by which operands are numbers of the type."""
OPERATORS: dict[Any, Any] = {
    operator.add: np.add,
    operator.sub: np.subtract,
    operator.mul: np.multiply,
    operator.truediv: np.divide,
    operator.pow: np.power,
    operator.neg: np.negative,
}


def register_number_operations(
    owner: Any, rules_by_operation: OperationRules, apply: Callable[..., Any], plain_operands: tuple[type, ...]
) -> None:
    """Give a number type its operations, with its own numbers and with the types ``plain_operands`` it.

    ``apply`` runs a rule on a tuple of operands in plain Python. With any other type, that type's operator is
    tried.
    """
    by_ufunc = {OPERATORS.get(operation, operation): rules for operation, rules in rules_by_operation.items()}

    def apply_ufunc_rule(number: Any, ufunc: Any, method: str, *operands: Any, **options: Any) -> Any:
        rule = by_ufunc.get(ufunc, {}).get(tuple([isinstance(operand, owner) for operand in operands]))
        return NotImplemented if method != "__call__" or options or rule is None else apply(rule, operands)

    def unary_operator(rules: Any) -> Any:
        return lambda number: apply(rules[OWN,], (number,))

    def binary_operator(rules: Any, operands_with_other: tuple[bool, bool]) -> Any:
        first = operands_with_other[0]

        def apply_binary_rule(number: Any, other: Any) -> Any:
            if isinstance(other, owner):
                rule = rules.get(OWN_PAIR)
            else:
                rule = rules.get(operands_with_other) if isinstance(other, plain_operands) else None
            if rule is None:
                return NotImplemented
            return apply(rule, (number, other) if first else (other, number))

        return apply_binary_rule

    owner.__array_ufunc__ = apply_ufunc_rule
    for operation, rules in rules_by_operation.items():
        _register_operation_in_kernels(operation, rules, owner, plain_operands)
        if operation is operator.neg:
            owner.__neg__ = unary_operator(rules)
        elif operation in OPERATORS:
            setattr(owner, f"__{operation.__name__}__", binary_operator(rules, (OWN, OTHER)))
            setattr(owner, f"__r{operation.__name__}__", binary_operator(rules, (OTHER, OWN)))


def _register_operation_in_kernels(
    operation: Any, rules: Any, owner: type, plain_operands: tuple[type, ...]
) -> None:
    """Let kernels apply an operation to a number type."""

    def rule_for_operand_types(*kinds: type) -> Any:
        fitting = all(issubclass(kind, (owner, *plain_operands)) for kind in kinds)
        return rules.get(tuple(kind is owner for kind in kinds)) if fitting else None

    chosen_by_type(operation)(
        (lambda a: rule_for_operand_types(a)) if (OWN,) in rules else (lambda a, b: rule_for_operand_types(a, b))
    )
