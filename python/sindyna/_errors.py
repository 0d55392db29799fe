"""Exceptions."""

from __future__ import annotations


class NotFittedError(ValueError, AttributeError):
    """A model is asked for something before it was fitted."""
