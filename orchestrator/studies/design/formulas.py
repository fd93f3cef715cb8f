"""Arithmetic that turns factors into values of a case's keys: ``"stroke_mm / 1000"``."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Mapping
from typing import Any

OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
FUNCTIONS = {
    name: getattr(math, name) for name in ("sqrt", "sin", "cos", "tan", "radians", "degrees", "exp", "log")
}
FUNCTIONS |= {
    "min": min,
    "max": max,
    "abs": abs,
    "round": lambda number, digits=0: round(number, int(digits)),
}
CONSTANTS = {"pi": math.pi}
LONGEST = 500  # characters: Python parses no formula of any depth


class BadFormula(ValueError):
    """A formula that is no arithmetic, or has no finite value; the message says what is wrong."""


def parse(text: str) -> ast.expr:
    """Parse a formula of numbers, names, ``+ - * / **``, brackets and a few functions.

    Raises BadFormula for something else.
    """
    if len(text) > LONGEST:
        raise BadFormula(f'"{text[:20]}..." has {len(text)} characters; {LONGEST} are the most')
    try:
        expression = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise BadFormula(f'"{text}" is not a formula of arithmetic') from None
    _check(expression, text)
    return expression


def names_in(expression: ast.expr) -> set[str]:
    """List the factors that a formula uses."""
    functions = {id(node.func) for node in ast.walk(expression) if isinstance(node, ast.Call)}
    names = {
        node.id for node in ast.walk(expression) if isinstance(node, ast.Name) and id(node) not in functions
    }
    return names - CONSTANTS.keys()


def value(expression: ast.expr, factors: Mapping[str, float]) -> float:
    """Compute a formula for values of the factors.

    Raises BadFormula where it divides by zero, has no finite real value, or gives a function other arguments
    than it takes.
    """
    try:
        result = _value(expression, factors)
    except (ArithmeticError, ValueError, TypeError) as error:
        raise BadFormula(f'"{ast.unparse(expression)}" has no value: {error}') from None
    if isinstance(result, complex) or not math.isfinite(result):
        raise BadFormula(f'"{ast.unparse(expression)}" has no finite value')
    return float(result)


def _check(node: ast.expr, text: str) -> None:
    if (
        isinstance(node, ast.Constant)
        and isinstance(node.value, int | float)
        and not isinstance(node.value, bool)
    ):
        return
    if isinstance(node, ast.Name):
        return
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
        return _check(node.operand, text)
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        _check(node.left, text)
        return _check(node.right, text)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords and node.args:
        if node.func.id not in FUNCTIONS:
            raise BadFormula(f'"{node.func.id}" is not a function; there are {", ".join(FUNCTIONS)}')
        for argument in node.args:
            _check(argument, text)
        return None
    raise BadFormula(f'"{text}": numbers, factors, + - * / **, brackets and {", ".join(FUNCTIONS)} are known')


def _value(node: ast.expr, factors: Mapping[str, float]) -> Any:
    match node:
        case ast.Constant(value=int() | float() as number):
            return float(number)  # powers of whole numbers may take for ever
        case ast.Name(id=name):
            return CONSTANTS[name] if name in CONSTANTS else factors[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_value(operand, factors)
        case ast.UnaryOp(operand=operand):
            return _value(operand, factors)
        case ast.BinOp(left=left, op=sign, right=right):
            return OPERATORS[type(sign)](_value(left, factors), _value(right, factors))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return FUNCTIONS[name](*(_value(argument, factors) for argument in arguments))
    raise AssertionError(f"{ast.dump(node)} was checked")
