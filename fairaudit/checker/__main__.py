"""Run the checker, from the package or from a copy of its folder under any name."""

from __future__ import annotations

import sys


def _run() -> int:
    if sys.version_info < (3, 10):  # noqa: UP036 - a copy of the folder meets any Python
        sys.stderr.write("The checker needs Python 3.10 or later, and this is %d.%d.\n" % sys.version_info[:2])  # noqa: UP031
        return 2
    if __package__:
        from .command import main

        return main()
    from os import devnull
    from os.path import abspath, dirname, join

    folder = dirname(abspath(__file__))
    sys.path[:] = [place for place in sys.path if abspath(place) != folder]  # no file of the folder stands in for a standard module
    from importlib.util import module_from_spec, spec_from_file_location

    sys.dont_write_bytecode, sys.pycache_prefix = True, join(devnull, "none")  # what runs is the text, not what was compiled beside it
    spec = spec_from_file_location("checker", join(folder, "__init__.py"), submodule_search_locations=[folder])
    if spec is None or spec.loader is None:
        sys.stderr.write(f"The folder {folder!r} holds no checker.\n")
        return 2
    package = module_from_spec(spec)
    sys.modules["checker"] = package
    spec.loader.exec_module(package)
    code: int = package.main()
    return code


if __name__ == "__main__":
    sys.exit(_run())
