# Run this cell first. It finds the course's folder and looks whether everything is there.
import sys
from pathlib import Path

folders = [p for p in (Path.cwd(), *Path.cwd().parents) if (p / "utils" / "checks").is_dir()]
assert folders, "No folder `utils` here: unzip the whole course and open the notebook from it."
sys.path.insert(0, str(folders[0]))
import utils; print(utils.health())
