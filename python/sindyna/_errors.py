"""Exceptions."""

from __future__ import annotations


class ConvergenceWarning(UserWarning):
    """A solver came to no rest in as many rounds as it may make."""


class NotFittedError(ValueError, AttributeError):
    """A model is asked for something before it was fitted."""
