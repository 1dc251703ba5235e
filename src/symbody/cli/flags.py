"""Options that are given or not: the help shows them without a word for a value."""

from __future__ import annotations

from typing import Any

from typer.core import TyperCommand, TyperGroup


class FlagCommand(TyperCommand):
    """A command whose flags read as flags: newer versions of typer write ``<bool>`` behind each."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options, those that typer adds too."""
        return _plain(super().get_params(ctx))


class FlagGroup(TyperGroup):
    """The same for the options before all commands."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options, those that typer adds too."""
        return _plain(super().get_params(ctx))


def _plain(options: list[Any]) -> list[Any]:
    for option in options:
        if getattr(option, "is_flag", False) and option.metavar is None:
            option.metavar = ""
    return options
