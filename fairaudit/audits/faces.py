"""What a result can do with itself: be saved, checked, shown. The one place where audits reach up, to reports and plots."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fairaudit.arguments import answered
from fairaudit.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fairaudit.certificates.certificate import Certificate
    from fairaudit.verified.verification import Verification

Form = Literal["json", "html", "pdf", "markdown"]

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

        Raises
        ------
        InputError
            If the name ends as that of something else, or a file cannot be written or was read.
        """
        ending = Path(path).suffix
        if ending.lower() not in ("", ".json"):
            raise InputError(f"{os.fspath(path)} ends in {ending!r}, and a certificate in '.json'; report() writes pages and markdown")
        files = getattr(getattr(self, "origin", None), "files", None)
        if files is not None:
            files.refuse(target for target, _ in self.certificate.files(path))
        return self.certificate.save(path)

    @answered
    def attest(
        self,
        path: str | os.PathLike[str],
        attestation: str | os.PathLike[str],
        *,
        issuer: str | None = None,
        contact: str | None = None,
        title: str | None = None,
        system: str | None = None,
        system_version: str | None = None,
        period: str | None = None,
    ) -> list[Path]:
        r"""Write the certificate, and beside it a statement of where it comes from (docs/attestation.md): both, or neither.

        The digests are of the files as `fairaudit.audit` read them: one that was changed since is refused.

        Parameters
        ----------
        path, attestation : path
            Where they go.
        issuer, contact, title, system, system_version : str, optional
            Who made the audit, what it is called, and of which system it is: only stated. What is left out is taken from the section
            ``[attestation]`` of an audit file, where there is one.
        period : str, optional
            First and last day of the decisions, such as ``"2025-01-01/2025-12-31"``.

        Returns
        -------
        list of Path
            The certificate and the attestation.

        Raises
        ------
        InputError
            If a file was changed or cannot be written, or a text has no place in a statement.

        Examples
        --------
        >>> import tempfile
        >>> import fairaudit as fa
        >>> folder = Path(tempfile.mkdtemp())
        >>> _ = (folder / "log.csv").write_text("hired,sex\nyes,f\nno,f\nyes,m\nno,m\n")
        >>> result = fa.audit(folder / "log.csv", decision="hired", group="sex", utility="yes")
        >>> written = result.attest(folder / "c.json", folder / "a.json", issuer="Example Audits")
        >>> fa.verify(written[0], attestation=written[1]).ok
        True
        """
        from fairaudit.attestations.making import write_attested

        given = {"issuer": issuer, "contact": contact, "title": title, "system": system, "system_version": system_version, "period": period}
        result: Any = self
        return write_attested(result, path, attestation, given)

    @answered
    def verify(self, require: Literal["within"] | None = None) -> Verification:
        """Check every statement of the certificate with the independent checker (`fairaudit.verify`)."""
        from fairaudit.verified.verification import verification_of

        return verification_of(self.certificate, require=require)

    @answered
    def report(self, path: str | os.PathLike[str] | None = None, *, format: Form | None = None) -> str:  # noqa: A002
        """Write the certificate as a page for people, in print or as markdown, after checking it (`fairaudit.report`)."""
        from fairaudit.reports.report import report

        return report(self.certificate, path, format=format)

    def _repr_html_(self) -> str:
        from fairaudit.reports.notebook import notebook

        result: Any = self
        return notebook(result)

    @answered
    def log_to_mlflow(self, *, prefix: str = "fairaudit", run_id: str | None = None) -> str:
        """Keep the result in a run of MLflow (extra ``mlflow``), with its certificate and page.

        Metrics are the ratios, differences and distances, the ends of their intervals rounded outwards, and the exit code; parameters
        what was asked for; tags the verdict and its sentence. What is infinite is not among the metrics.

        Parameters
        ----------
        prefix : str
            What the names of metrics, parameters and tags begin with, and the folder of the artifacts; a run holds one result under each.
        run_id : str, optional
            The run; by default the active one, or a new one that is ended.

        Returns
        -------
        str
            The run.

        Raises
        ------
        InputError
            If mlflow is missing, or the run does not take the result.
        """
        try:
            from fairaudit.mlflow_plugin import log
        except ImportError as error:
            if (error.name or "").partition(".")[0] != "mlflow":
                raise
            raise InputError("this needs the library mlflow: pip install 'fairaudit-certify[mlflow]'") from None
        result: Any = self
        return log(result, prefix=prefix, run_id=run_id)

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
