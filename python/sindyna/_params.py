"""Parameters as scikit-learn has them, without scikit-learn."""

from __future__ import annotations

from typing import Any, TypeVar

Self = TypeVar("Self", bound="Parameters")


class Parameters:
    """Something made of the arguments of its constructor, each kept under its own name."""

    @classmethod
    def _parameter_names(cls) -> list[str]:
        code = cls.__init__.__code__
        return list(code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount])

    @classmethod
    def _defaults(cls) -> dict[str, Any]:
        function: Any = cls.__init__
        code, defaults = function.__code__, function.__defaults__ or ()
        positional = code.co_varnames[1 : code.co_argcount]
        known = dict(zip(positional[len(positional) - len(defaults) :], defaults, strict=True))
        return {**known, **(function.__kwdefaults__ or {})}

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """
        The parameters by name.

        Parameters
        ----------
        deep : bool
            Whether parameters of parameters are told too, as ``optimizer__threshold``.

        Returns
        -------
        dict
            Values by name.
        """
        params = {name: getattr(self, name) for name in self._parameter_names()}
        if deep:
            for name, value in list(params.items()):
                if isinstance(value, Parameters):
                    params.update({f"{name}__{key}": inner for key, inner in value.get_params().items()})
        return params

    def set_params(self: Self, **params: Any) -> Self:
        """
        Sets parameters by name, those of parameters as ``optimizer__threshold``.

        Returns
        -------
        self
        """
        known = self._parameter_names()
        inner: dict[str, dict[str, Any]] = {}
        for key, value in params.items():
            name, _, rest = key.partition("__")
            if name not in known:
                raise ValueError(f"{type(self).__name__} has no parameter {name!r}; parameters: {', '.join(known)}")
            if rest:
                inner.setdefault(name, {})[rest] = value
            else:
                setattr(self, name, value)
        for name, values in inner.items():
            target = getattr(self, name)
            if not isinstance(target, Parameters):
                raise ValueError(f"{name} is {target!r}, which has no parameters; set it first")
            target.set_params(**values)
        return self

    def __repr__(self) -> str:
        defaults = self._defaults()
        told = []
        for name in self._parameter_names():
            value = getattr(self, name)
            is_default = (
                name in defaults and type(value) is type(defaults[name]) and repr(value) == repr(defaults[name])
            )
            if not is_default:
                told.append(f"{name}={value!r}")
        return f"{type(self).__name__}({', '.join(told)})"


def whole(name: str, value: Any, least: int) -> int:
    """A whole number of at least so much."""
    if isinstance(value, bool) or not hasattr(value, "__index__") or value.__index__() < least:
        raise ValueError(f"{name} must be a whole number of at least {least}, got {value!r}")
    return int(value.__index__())
