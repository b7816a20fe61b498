"""The names that notebooks import: clouds, the simulated scanner, figures and checks.

Each name is loaded on first use, so that ``import utils`` is fast.
"""

import importlib
import sys
from importlib.machinery import ModuleSpec
from types import FunctionType, ModuleType

_MODULE_OF = {
    "ask_about": "utils.questions.ask",
    "check": "utils.checks",
    "load_cloud": "utils.datasets",
    "load_sequence": "utils.datasets",
    "load_street": "utils.datasets",
    "fetch_recording": "utils.datasets",
    "load_my_functions": "utils.notebooks.my_functions",
    "read_cloud": "utils.clouds",
    "read_sequence": "utils.clouds",
    "read_bag": "utils.recordings",
    "begin": "utils.notebook_setup",
    "is_written": "utils.lent",
    "predict": "utils.predictions",
    "ready": "utils.checks.waiting_cells",
    "show_table": "utils.tables",
    "replay": "utils.replays",
    "write_cloud": "utils.clouds",
}
# Old names of moved modules, which notebooks released earlier still import.
_NEW_MODULE_NAMES = {
    "ground": "utils.simulator.ground",
    "recording": "utils.films",
    "streets": "utils.simulator.streets",
    "traffic": "utils.simulator.traffic",
}
_MODULES = _NEW_MODULE_NAMES | {
    name: f"utils.{name}"
    for name in (
        "boxes",
        "checks",
        "clouds",
        "datasets",
        "drive",
        "films",
        "play",
        "plots",
        "recordings",
        "scene3d",
        "scenes",
        "scoring",
        "simulator",
        "tracking",
    )
}

__all__ = [*_MODULE_OF, *_MODULES, "health"]


def __getattr__(name: str) -> FunctionType | ModuleType:
    if name in _MODULE_OF:
        return getattr(importlib.import_module(_MODULE_OF[name]), name)
    if name in _MODULES:
        return importlib.import_module(_MODULES[name])
    raise AttributeError(f"module 'utils' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)


class _OldModuleNameFinder:
    """Import hook for old module names, as in ``from utils.ground import Ground``."""

    @staticmethod
    def find_spec(name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        package, _, part = name.rpartition(".")
        return (
            ModuleSpec(name, _OldModuleNameFinder)
            if package == __name__ and part in _NEW_MODULE_NAMES
            else None
        )

    @staticmethod
    def create_module(spec: ModuleSpec) -> None:
        """Return None to get Python's default module, which `exec_module` replaces."""

    @staticmethod
    def exec_module(module: ModuleType) -> None:
        part = module.__name__.rpartition(".")[2]
        sys.modules[module.__name__] = importlib.import_module(_NEW_MODULE_NAMES[part])


sys.meta_path.append(_OldModuleNameFinder)


def health() -> str:
    """Return a one-line report on whether this machine is ready for the course."""
    import platform
    from importlib import metadata, util
    from pathlib import Path

    needed = ("numpy", "scipy", "matplotlib")
    if missing := [name for name in needed if not util.find_spec(name)]:
        return f"Not ready. Install the missing packages: pip install {' '.join(missing)}"
    if not (Path(__file__).parent.parent / "data" / "cloud.txt").exists():
        return "Not ready. The file data/cloud.txt is missing. Unzip the whole course folder."
    ready = f"Ready: Python {platform.python_version()}, NumPy {metadata.version('numpy')}."
    if sys.platform != "wasi" and not ("ipywidgets" in sys.modules or util.find_spec("ipywidgets")):
        ready += " To make sliders move, run: pip install ipywidgets"
    return ready
