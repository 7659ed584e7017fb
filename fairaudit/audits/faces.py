"""What a result can do with itself: be saved, checked, shown. The one place where audits reach up, to reports and plots."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fairaudit.arguments import answered
from fairaudit.verified.verification import Verification, verify

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fairaudit.certificates.certificate import Certificate

Picture = Literal["expectations", "ratios", "bounds"]


class Faces:
    """What a result can do with its certificate."""

    @property
    def certificate(self) -> Certificate:
        """The certificate of the result."""
        raise NotImplementedError

    @answered
    def save(self, path: str | os.PathLike[str]) -> list[Path]:
        """Write the certificate, and beside it the canonical table if that is not embedded (`Certificate.save`).

        Returns
        -------
        list of Path
            The files written, the certificate first.
        """
        return self.certificate.save(path)

    @answered
    def verify(self, require: Literal["within"] | None = None) -> Verification:
        """Check every statement of the certificate with the independent checker (`fairaudit.verify`)."""
        return verify(self.certificate, require=require)

    @answered
    def report(self, path: str | os.PathLike[str] | None = None, *, format: Literal["html", "markdown"] = "html") -> str:  # noqa: A002
        """Write the certificate as a page for people, or as markdown, after checking it (`fairaudit.report`)."""
        from fairaudit.reports.report import report

        return report(self.certificate, path, format=format)

    @answered
    def plot(self, path: str | os.PathLike[str] | None = None, *, picture: Picture = "expectations") -> Axes:
        """Draw the result with matplotlib (extra ``plots``).

        Parameters
        ----------
        path : path, optional
            A PNG, SVG or PDF file to write.
        picture : {"expectations", "ratios", "bounds"}
            What each group gets, the pairwise ratios of the most unequal context, or what is known of the local ratio.

        Returns
        -------
        Axes
            The drawing.

        Raises
        ------
        InputError
            If matplotlib is missing, or the file cannot be written.
        """
        from fairaudit.plots import draw

        result: Any = self
        return draw(result, picture, path)
