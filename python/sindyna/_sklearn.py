"""What scikit-learn asks of an estimator. It is imported only when it asks."""

from __future__ import annotations

import copy
from typing import Any, ClassVar, TypeVar

Self = TypeVar("Self", bound="Manners")


class Tagged:
    """Tags."""

    def __sklearn_tags__(self) -> Any:
        from sklearn.utils import Tags, TargetTags

        return Tags(estimator_type=None, target_tags=TargetTags(required=False))


class Manners(Tagged):
    """Tags and metadata routing."""

    #: Arguments of methods that scikit-learn may route.
    _ROUTED: ClassVar = {"fit": ("t", "u", "x_dot", "feature_names"), "predict": ("u",), "score": ("t", "u", "x_dot")}

    def __sklearn_is_fitted__(self) -> bool:
        return getattr(self, "_fitted", None) is not None

    def _requested(self: Self, method: str, requests: dict[str, Any]) -> Self:
        unknown = set(requests) - set(self._ROUTED[method])
        if unknown:
            raise TypeError(
                f"{method} has no argument {sorted(unknown)[0]!r}; arguments: {', '.join(self._ROUTED[method])}"
            )
        request = self.get_metadata_routing()
        for name, alias in requests.items():
            getattr(request, method).add_request(param=name, alias=alias)
        self._metadata_request = request
        return self

    def set_fit_request(self: Self, **requests: Any) -> Self:
        """
        Tells scikit-learn's metadata routing which arguments `fit` takes: ``set_fit_request(t=True, u=True)``.

        Returns
        -------
        self
        """
        return self._requested("fit", requests)

    def set_predict_request(self: Self, **requests: Any) -> Self:
        """
        Tells scikit-learn's metadata routing which arguments `predict` takes.

        Returns
        -------
        self
        """
        return self._requested("predict", requests)

    def set_score_request(self: Self, **requests: Any) -> Self:
        """
        Tells scikit-learn's metadata routing which arguments `score` takes: ``set_score_request(t=True, u=True)``.

        Returns
        -------
        self
        """
        return self._requested("score", requests)

    def get_metadata_routing(self) -> Any:
        """
        What scikit-learn's metadata routing asks for.

        Returns
        -------
        sklearn.utils.metadata_routing.MetadataRequest
        """
        from sklearn.utils.metadata_routing import MetadataRequest

        own = getattr(self, "_metadata_request", None)
        if own is not None:
            return copy.deepcopy(own)
        request = MetadataRequest(owner=self)
        for method, names in self._ROUTED.items():
            for name in names:
                getattr(request, method).add_request(param=name, alias=None)
        return request
