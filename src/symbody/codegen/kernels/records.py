"""Where fields of records lie, as expressions of the kernel language."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass

from symbody.codegen.kernels.source import KernelSource
from symbody.codegen.kernels.tree import (
    Apply,
    ArrayEntry,
    Expression,
    Literal,
    Part,
    Type,
    Variable,
    add,
)
from symbody.kernels.record_layout import RecordField, RecordLayout

_ZERO = Literal(0, Type.INTEGER)


@dataclass(frozen=True, slots=True)
class RecordPlace:
    """Where a record lies: its class, the array, and where it begins there, an integer."""

    record: type[RecordLayout]
    array: Expression
    offset: Expression = _ZERO

    @property
    def whole(self) -> Expression:
        """The record as an array."""
        if self.offset == _ZERO:
            return self.array
        return Part(self.array, self.offset, Literal(self.record.size, Type.INTEGER))

    def entry(self, field: RecordField) -> ArrayEntry:
        """Return the entry of a field: its number, or where it is stored."""
        return ArrayEntry(self.array, add(self.offset, field.place))

    def number(self, field: RecordField) -> Expression:
        """Return the value of a field that is a number."""
        entry = self.entry(field)
        return entry if field.kind is float else Apply("integer", (entry,), Type.INTEGER)

    def begin(self, field: RecordField) -> Expression:
        """Return where what a field stores begins in the array."""
        place = Apply("integer", (self.entry(field),), Type.INTEGER)
        return place if self.offset == _ZERO else Apply("+", (self.offset, place), Type.INTEGER)

    def reals(self, field: RecordField) -> Part:
        """Return the reals that a field stores."""
        return Part(self.array, self.begin(field), self._count(field))

    def inline(self, field: RecordField) -> Part:
        """Return the reals that a field is."""
        return Part(self.array, add(self.offset, field.place), Literal(field.inline, Type.INTEGER))

    def inner(self, field: RecordField, index: Expression | None = None) -> RecordPlace:
        """Return the record that a field is or stores; of several the one with an index."""
        if field.pointer is None:
            return RecordPlace(field.kind, self.array, add(self.offset, field.place))
        begin = self.begin(field)
        if index is not None:
            size = Literal(field.kind.size, Type.INTEGER)
            step = size if index == Literal(1, Type.INTEGER) else Apply("*", (size, index), Type.INTEGER)
            begin = begin if index == _ZERO else Apply("+", (begin, step), Type.INTEGER)
        return RecordPlace(field.kind, self.array, begin)

    def _count(self, field: RecordField) -> Expression:
        factors = () if field.pointer is None else field.pointer.factors
        counts: list[Expression] = [
            self.number(self.record.fields[factor])
            if isinstance(factor, str)
            else Literal(factor, Type.INTEGER)
            for factor in factors
        ] or [Literal(1, Type.INTEGER)]
        product = counts[0]
        for count in counts[1:]:
            product = Apply("*", (product, count), Type.INTEGER)
        return product


class RecordReader:
    """Reads what names of fields stand for in one function.

    Parameters
    ----------
    classes : mapping of name to class
        Of the parameters and variables that are records; grows with assignments.
    read : callable
        Returns the tree of an expression as a value of a type.
    """

    def __init__(
        self,
        source: KernelSource,
        classes: dict[str, type[RecordLayout]],
        read: Callable[[ast.expr, Type], Expression],
    ) -> None:
        self.classes = classes
        self._source = source
        self._read = read

    def find(self, node: ast.expr) -> RecordPlace | None:
        """Return where the record lies that an expression is; None if it is none."""
        match node:
            case ast.Name(id=name) if name in self.classes:
                return RecordPlace(self.classes[name], Variable(name, Type.ARRAY))
            case ast.Subscript(value=ast.Attribute() as rows, slice=index) if (
                self.find(rows.value) is not None
            ):
                place, field = self._field(rows)
                return place.inner(field, self._read(index, Type.INTEGER)) if field.is_row else None
            case ast.Attribute() if self.find(node.value) is not None:
                place, field = self._field(node)
                return place.inner(field) if field.is_record and not field.is_row else None
            case ast.Call(func=ast.Attribute(value=ast.Name(id=name), attr="view"), args=[array, begin]) if (
                name in self._source.records
            ):
                whole, offset = self._read(array, Type.ARRAY), self._read(begin, Type.INTEGER)
                return RecordPlace(self._source.records[name], whole, offset)
        return None

    def value(self, node: ast.Attribute) -> Expression:
        """Return the number or the reals of a field, or the size of a class of records."""
        if isinstance(node.value, ast.Name) and node.attr == "size":
            kind = self._source.records.get(node.value.id)
            if kind is not None:
                return Literal(kind.size, Type.INTEGER)
        place, field = self._field(node)
        if field.is_row:
            self._source.refuse(node, f"{field.name} are several records", "take one of them by its index")
        if field.inline:
            return place.inline(field)
        return place.number(field) if field.pointer is None else place.reals(field)

    def number(self, node: ast.Attribute) -> tuple[ArrayEntry, Type]:
        """Return the entry of a number, to store into, and the type of its values."""
        place, field = self._field(node)
        if field.kind not in {float, int}:
            self._source.refuse(node, f"{field.name} is no number", "store into its entries")
        return place.entry(field), Type.REAL if field.kind is float else Type.INTEGER

    def exists(self, node: ast.Attribute) -> Expression:
        """Return whether a record that is stored elsewhere is there."""
        place, field = self._field(node)
        return Apply("!=", (place.entry(field), Literal(0.0, Type.REAL)), Type.TRUTH)

    def _field(self, node: ast.Attribute) -> tuple[RecordPlace, RecordField]:
        place = self.find(node.value)
        if place is None:
            self._source.refuse(node, f"{ast.unparse(node.value)} is no record", "declare it as one")
        field = place.record.fields.get(node.attr)
        if field is None:
            names = ", ".join(place.record.fields)
            self._source.refuse(
                node, f"{place.record.__name__} has no field {node.attr}", f"use one of {names}"
            )
        return place, field
